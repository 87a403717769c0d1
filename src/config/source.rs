//! The texts that a config is made of, files and command-line overrides, and places inside them.
use std::sync::Arc;

/// How a text entered the config.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Manner {
    /// Read from a file.
    File,
    /// `key=value` on the command line: keys named before byte `path_end` must exist already.
    Change { path_end: usize },
    /// `+key=value` or `~key` on the command line.
    Edit,
}

/// One text with the name that errors show.
#[derive(Clone, Debug)]
pub(super) struct Source {
    pub(super) name: String,
    pub(super) text: Arc<str>,
    pub(super) manner: Manner,
}

/// A byte range of one source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) source: usize,
    pub(super) start: usize,
    pub(super) end: usize,
}

impl Place {
    /// The bytes `start..end` of source number `source`.
    pub(super) fn new(source: usize, span: std::ops::Range<usize>) -> Self {
        Self { source, start: span.start, end: span.end }
    }
}

/// All texts of one config, in the order they were read.
#[derive(Clone, Debug, Default)]
pub(super) struct Sources {
    list: Vec<Source>,
}

impl Sources {
    /// Remembers a text and returns its number.
    pub(super) fn add(&mut self, name: String, text: String, manner: Manner) -> usize {
        self.list.push(Source { name, text: text.into(), manner });
        self.list.len() - 1
    }

    /// The text that a place lies in.
    pub(super) fn of(&self, place: Place) -> &Source {
        &self.list[place.source]
    }

    /// How many texts there are.
    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// The `file:line` of a place, or the override it stands in.
    pub(super) fn describe(&self, place: Place) -> String {
        let source = self.of(place);
        match source.manner {
            Manner::File => format!("{}:{}", source.name, line_and_column(&source.text, place.start).0),
            Manner::Change { .. } | Manner::Edit => source.name.clone(),
        }
    }

    /// Whether a key exists only because a plain `key=value` on the command line names it.
    pub(super) fn presumed(&self, key: Place) -> bool {
        matches!(self.of(key).manner, Manner::Change { path_end } if key.end <= path_end)
    }
}

/// Line and column of a byte, both from one, the column in characters.
pub(super) fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let mut byte = byte.min(text.len());
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    let before = &text[..byte];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}
