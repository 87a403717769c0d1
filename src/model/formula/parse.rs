//! Text to expression, by precedence: `+ -` below `* /` below the sign below `^`, which binds from the right.
use super::error::FormulaError;
use super::expression::{Expressions, FUNCTIONS, Function, Id};
use super::rational::Rational;
use super::token::{Token, Word, tokens};
use crate::config::nearest;

/// The names that a formula may use.
#[derive(Clone, Copy, Debug)]
pub enum Names<'a> {
    /// Whatever it says.
    Any,
    /// These.
    Only(&'a [&'a str]),
}

/// How deep parentheses, signs and exponents may be nested.
const DEPTH: usize = 64;

/// Functions beside [`FUNCTIONS`], with their number of operands.
const OTHERS: &[(&str, usize)] = &[("sqrt", 1), ("max", 2), ("min", 2)];

impl Expressions {
    /// The expression that `text` describes.
    ///
    /// # Errors
    /// What is wrong and at which column: an unknown name or function with the nearest known one, a missing operand or
    /// parenthesis, an exponent that is no number.
    pub fn parse(&mut self, text: &str, names: Names<'_>) -> Result<Id, FormulaError> {
        let mut parser = Parser { text, tokens: tokens(text)?, at: 0, depth: 0, names, expressions: self };
        let found = parser.sum()?;
        match parser.word() {
            Word::End => Ok(found),
            Word::Mark(')') => Err(parser.error("this parenthesis closes nothing")),
            _ => Err(parser.error("an operator is missing before this")),
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    tokens: Vec<Token>,
    at: usize,
    depth: usize,
    names: Names<'a>,
    expressions: &'a mut Expressions,
}

impl Parser<'_> {
    fn word(&self) -> &Word {
        &self.tokens[self.at].word
    }

    /// Whether the next word is `mark`, which is then taken.
    fn take(&mut self, mark: char) -> bool {
        let found = *self.word() == Word::Mark(mark);
        self.at += usize::from(found);
        found
    }

    fn error(&self, message: impl Into<String>) -> FormulaError {
        let token = &self.tokens[self.at];
        FormulaError::new(self.text, token.start, token.end, message)
    }

    fn sum(&mut self) -> Result<Id, FormulaError> {
        let mut sum = self.product()?;
        loop {
            if self.take('+') {
                let term = self.product()?;
                sum = self.expressions.sum(sum, term);
            } else if self.take('-') {
                let term = self.product()?;
                sum = self.expressions.difference(sum, term);
            } else {
                return Ok(sum);
            }
        }
    }

    fn product(&mut self) -> Result<Id, FormulaError> {
        let mut product = self.signed()?;
        loop {
            if self.take('*') {
                let factor = self.signed()?;
                product = self.expressions.product(product, factor);
            } else if self.take('/') {
                let divisor = self.signed()?;
                if self.expressions.as_number(divisor) == Some(Rational::ZERO) {
                    self.at -= 1;
                    return Err(self.error("this divides by zero"));
                }
                product = self.expressions.quotient(product, divisor);
            } else {
                return Ok(product);
            }
        }
    }

    fn signed(&mut self) -> Result<Id, FormulaError> {
        if self.depth == DEPTH {
            return Err(self.error(format!("a formula may be nested {DEPTH} deep; split it")));
        }
        self.depth += 1;
        let found = if self.take('-') {
            let a = self.signed()?;
            self.expressions.negative(a)
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(found)
    }

    fn power(&mut self) -> Result<Id, FormulaError> {
        let base = self.operand()?;
        if !self.take('^') {
            return Ok(base);
        }
        let start = self.tokens[self.at].start;
        let exponent = self.signed()?;
        let end = self.tokens[self.at - 1].end;
        let number = self.expressions.as_number(exponent).filter(|p| p.value().abs() <= 64.0);
        let Some(number) = number else {
            let message = "an exponent must be a number between -64 and 64; for x^n write exp(n * log(x))";
            return Err(FormulaError::new(self.text, start, end, message));
        };
        Ok(self.expressions.power(base, number))
    }

    fn operand(&mut self) -> Result<Id, FormulaError> {
        match self.word().clone() {
            Word::Number(number) => {
                self.at += 1;
                Ok(self.expressions.number(number))
            }
            Word::Mark('(') => {
                let open = self.at;
                self.at += 1;
                let inside = self.sum()?;
                self.close(open)?;
                Ok(inside)
            }
            Word::Name(name) if self.tokens[self.at + 1].word == Word::Mark('(') => self.call(&name),
            Word::Name(name) => self.name(&name),
            Word::Mark(_) => Err(self.error("a number, a name or `(` must stand here")),
            Word::End => Err(self.error("the formula ends where a number, a name or `(` must stand")),
        }
    }

    fn close(&mut self, open: usize) -> Result<(), FormulaError> {
        if self.take(')') {
            return Ok(());
        }
        match self.word() {
            Word::End => {
                self.at = open;
                Err(self.error("this parenthesis is never closed"))
            }
            Word::Mark(',') => Err(self.error("one operand is enough here; `,` separates those of max and min")),
            _ => Err(self.error("an operator or `)` is missing before this")),
        }
    }

    fn name(&mut self, name: &str) -> Result<Id, FormulaError> {
        if let Names::Only(known) = self.names
            && !known.contains(&name)
        {
            return Err(self.error(unknown("name", name, known)));
        }
        self.at += 1;
        Ok(self.expressions.name(name))
    }

    fn call(&mut self, name: &str) -> Result<Id, FormulaError> {
        let simple = FUNCTIONS.iter().find(|(known, _)| *known == name).map(|(_, function)| *function);
        let other = OTHERS.iter().find(|(known, _)| *known == name).map(|(_, count)| *count);
        let Some(count) = simple.map(|_| 1).or(other) else {
            let known: Vec<&str> = FUNCTIONS.iter().map(|(n, _)| *n).chain(OTHERS.iter().map(|(n, _)| *n)).collect();
            return Err(self.error(unknown("function", name, &known)));
        };
        self.at += 1;
        let open = self.at;
        self.at += 1;
        let first = self.sum()?;
        let second = match count {
            2 if self.take(',') => Some(self.sum()?),
            2 => return Err(self.error(format!("{name} takes two operands, separated by `,`"))),
            _ => None,
        };
        self.close(open)?;
        Ok(self.made(name, simple, first, second))
    }

    fn made(&mut self, name: &str, function: Option<Function>, a: Id, b: Option<Id>) -> Id {
        match (function, b) {
            (Some(function), _) => self.expressions.apply(function, a),
            (None, Some(b)) if name == "max" => self.expressions.max(a, b),
            (None, Some(b)) => self.expressions.min(a, b),
            (None, None) => self.expressions.power(a, Rational::HALF),
        }
    }
}

/// A sentence about a name that is none of `known`.
pub(super) fn unknown(what: &str, name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter().copied()) {
        Some(near) => format!("unknown {what} `{name}`; did you mean `{near}`?"),
        None => format!("unknown {what} `{name}`; there are {}", known.join(", ")),
    }
}
