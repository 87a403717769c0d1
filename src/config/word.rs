//! The values of command-line overrides: TOML, in which a bare word is a string.
use super::error::ConfigError;
use super::parse::DEEPEST;
use super::source::{Place, Sources};
use super::tree::{Entry, Node, Table, Value};

/// Reads one override from left to right.
pub(super) struct Reader<'a> {
    pub(super) text: &'a str,
    pub(super) at: usize,
    pub(super) source: usize,
    pub(super) sources: &'a Sources,
}

impl Reader<'_> {
    /// An error about the bytes from `start` to where the reader is.
    pub(super) fn refuse(&self, why: impl Into<String>, start: usize) -> ConfigError {
        let end = self.at.max(start + 1).min(self.text.len()).max(start);
        ConfigError::new(why).spotted(self.sources, Some(self.place(start, end)))
    }

    pub(super) fn place(&self, start: usize, end: usize) -> Place {
        Place::new(self.source, start..end)
    }

    pub(super) fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    pub(super) fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        self.at += if found { wanted.len_utf8() } else { 0 };
        found
    }

    fn blanks(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += self.peek().map_or(0, char::len_utf8);
        }
    }

    /// The value that is the rest of the text.
    pub(super) fn whole_value(&mut self) -> Result<Node, ConfigError> {
        self.blanks();
        let node = self.value(&[], 0)?;
        self.blanks();
        match self.at < self.text.len() {
            true => Err(self.refuse("nothing may follow the value", self.at)),
            false => Ok(node),
        }
    }

    fn value(&mut self, ends: &[char], depth: usize) -> Result<Node, ConfigError> {
        let start = self.at;
        if depth > DEEPEST {
            return Err(self.refuse(format!("values are nested more than {DEEPEST} deep"), start));
        }
        let value = match self.peek() {
            Some('[') => self.list(depth)?,
            Some('{') => self.table(depth)?,
            Some('"' | '\'') => Value::Text(self.quoted()?),
            _ => {
                let rest = &self.text[start..];
                let length = rest.find(|letter| ends.contains(&letter)).unwrap_or(rest.len());
                self.at = start + rest[..length].trim_end().len();
                self.bare(start)?
            }
        };
        Ok(Node { value, place: Some(self.place(start, self.at)) })
    }

    fn bare(&self, start: usize) -> Result<Value, ConfigError> {
        let word = &self.text[start..self.at];
        Ok(match word.parse::<toml_edit::Value>() {
            Ok(toml_edit::Value::Boolean(flag)) => Value::Flag(*flag.value()),
            Ok(toml_edit::Value::Integer(integer)) => Value::Integer(*integer.value()),
            Ok(toml_edit::Value::Float(number)) if number.value().is_finite() => Value::Number(*number.value()),
            Ok(toml_edit::Value::Float(_)) => return Err(self.refuse("a number here must be finite", start)),
            _ => Value::Text(word.to_owned()),
        })
    }

    /// A string in quotes, with TOML's escapes.
    pub(super) fn quoted(&mut self) -> Result<String, ConfigError> {
        let start = self.at;
        let quote = self.peek().unwrap_or('"');
        self.at += quote.len_utf8();
        let mut escaped = false;
        while let Some(letter) = self.peek() {
            self.at += letter.len_utf8();
            if letter == quote && !escaped {
                let text = &self.text[start..self.at];
                let parsed = text.parse::<toml_edit::Value>().ok().and_then(|value| value.as_str().map(str::to_owned));
                return parsed.ok_or_else(|| self.refuse("this is not a TOML string", start));
            }
            escaped = letter == '\\' && quote == '"' && !escaped;
        }
        Err(self.refuse("the closing quote is missing", start))
    }

    fn list(&mut self, depth: usize) -> Result<Value, ConfigError> {
        let start = self.at;
        let mut items = Vec::new();
        self.at += 1;
        loop {
            self.blanks();
            if self.take(']') {
                return Ok(Value::List(items));
            }
            if self.peek().is_none() {
                return Err(self.refuse("the closing `]` is missing", start));
            }
            items.push(self.value(&[',', ']'], depth + 1)?);
            self.blanks();
            if !self.take(',') && self.peek() != Some(']') {
                return Err(self.refuse("the closing `]` is missing", start));
            }
        }
    }

    fn table(&mut self, depth: usize) -> Result<Value, ConfigError> {
        let start = self.at;
        let mut entries = Table::new();
        self.at += 1;
        loop {
            self.blanks();
            if self.take('}') {
                return Ok(Value::Table(entries));
            }
            let (key, place) = self.key(&['=', ':', ',', '}'])?;
            self.blanks();
            if !self.take('=') && !self.take(':') {
                return Err(self.refuse("a table is `{key=value, …}`", start));
            }
            self.blanks();
            let node = self.value(&[',', '}'], depth + 1)?;
            entries.insert(key, Entry { key: Some(place), node });
            self.blanks();
            if !self.take(',') && self.peek() != Some('}') {
                return Err(self.refuse("the closing `}` is missing", start));
            }
        }
    }

    /// One key, up to any of `ends`.
    pub(super) fn key(&mut self, ends: &[char]) -> Result<(String, Place), ConfigError> {
        let start = self.at;
        if matches!(self.peek(), Some('"' | '\'')) {
            let key = self.quoted()?;
            return Ok((key, self.place(start, self.at)));
        }
        let rest = &self.text[start..];
        let length = rest.find(|letter| ends.contains(&letter)).unwrap_or(rest.len());
        let key = rest[..length].trim();
        self.at = start + length;
        if key.is_empty() || key.contains(char::is_whitespace) {
            return Err(self.refuse("a key is missing here", start));
        }
        Ok((key.to_owned(), self.place(start, start + rest[..length].trim_end().len())))
    }
}
