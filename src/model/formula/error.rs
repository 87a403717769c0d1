//! What is wrong with the text of a formula, and where.
use std::fmt;

/// A sentence, and the formula with carets under the culprit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormulaError {
    text: String,
    /// First character and number of characters of the culprit.
    start: usize,
    width: usize,
    message: String,
}

impl FormulaError {
    /// `start` and `end` are bytes of `text`.
    pub(super) fn new(text: &str, start: usize, end: usize, message: impl Into<String>) -> Self {
        let count = |part: &str| part.chars().count();
        let shown = text.replace(['\n', '\r', '\t'], " ");
        Self {
            text: shown,
            start: count(&text[..start]),
            width: count(&text[start..end]).max(1),
            message: message.into(),
        }
    }

    /// The column of the culprit, from 1.
    pub fn column(&self) -> usize {
        self.start + 1
    }
}

impl fmt::Display for FormulaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (indent, carets) = (" ".repeat(self.start), "^".repeat(self.width));
        write!(f, "{} (column {})\n  {}\n  {indent}{carets}", self.message, self.column(), self.text)
    }
}

impl std::error::Error for FormulaError {}
