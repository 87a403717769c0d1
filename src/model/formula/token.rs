//! The words of a formula.
use super::error::FormulaError;
use super::rational::Rational;

/// A word and where it stands, in bytes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token {
    pub(super) word: Word,
    pub(super) start: usize,
    pub(super) end: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Word {
    Number(Rational),
    Name(String),
    /// One of `+ - * / ^ ( ) ,`.
    Mark(char),
    End,
}

/// Formulas of more words than this are refused: nobody wrote them by hand, and parsing recurs.
const WORDS: usize = 1000;

/// The words of `text`, [`Word::End`] last.
///
/// # Errors
/// At a character that no formula has, a number that is none or does not fit, and beyond a thousand words.
pub(super) fn tokens(text: &str) -> Result<Vec<Token>, FormulaError> {
    let mut tokens = Vec::new();
    let mut rest = text;
    loop {
        rest = rest.trim_start();
        let start = text.len() - rest.len();
        let Some(first) = rest.chars().next() else {
            tokens.push(Token { word: Word::End, start, end: start });
            return Ok(tokens);
        };
        if tokens.len() == WORDS {
            return Err(FormulaError::new(
                text,
                start,
                start,
                format!("a formula has at most {WORDS} words; split it"),
            ));
        }
        let (word, length) = match first {
            '0'..='9' | '.' => {
                let length = number_length(rest);
                let number = rest[..length].parse().map_err(|()| {
                    let message = format!(
                        "`{}` is no number that fits in 18 digits; name it as a constant to write any double",
                        &rest[..length]
                    );
                    FormulaError::new(text, start, start + length, message)
                })?;
                (Word::Number(number), length)
            }
            c if c.is_alphabetic() || c == '_' => {
                let inside = |c: char| c.is_alphanumeric() || c == '_';
                let length = rest.find(|c| !inside(c)).unwrap_or(rest.len());
                (Word::Name(rest[..length].to_owned()), length)
            }
            '+' | '-' | '*' | '/' | '^' | '(' | ')' | ',' => (Word::Mark(first), 1),
            _ => {
                let message =
                    format!("`{first}` means nothing in a formula; there are + - * / ^ ( ) , names and numbers");
                return Err(FormulaError::new(text, start, start + first.len_utf8(), message));
            }
        };
        tokens.push(Token { word, start, end: start + length });
        rest = &rest[length..];
    }
}

/// Bytes of the number that `text` begins with: digits, a point, an exponent.
fn number_length(text: &str) -> usize {
    let mut length = 0;
    let bytes = text.as_bytes();
    while let Some(byte) = bytes.get(length) {
        let exponent = matches!(byte, b'e' | b'E');
        let signed = matches!(bytes.get(length + 1), Some(b'+' | b'-'));
        let digit = bytes.get(length + 1 + usize::from(signed)).is_some_and(u8::is_ascii_digit);
        match byte {
            b'0'..=b'9' | b'.' => length += 1,
            _ if exponent && digit => length += 1 + usize::from(signed),
            _ => break,
        }
    }
    length
}
