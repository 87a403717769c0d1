//! Config errors that point at the place to mend.
use super::resolved::Resolved;
use super::source::{Manner, Place, Sources, line_and_column};
use miette::{Diagnostic, GraphicalReportHandler, LabeledSpan, NamedSource, SourceCode, SourceSpan};
use std::fmt;
use std::sync::Arc;

/// Lines of more bytes than this are not drawn: nobody wrote them by hand.
const DRAWN_LINE: usize = 2000;

/// Why a config was refused: a sentence, the place to mend, and how.
///
/// `Display` is one line that names the file and the line (or the override); [`ConfigError::graphical`] and
/// [`ConfigError::plain`] also draw the line with a caret, and every further problem of the same config.
#[derive(Debug, Clone)]
pub struct ConfigError(Box<Problem>);

#[derive(Debug, Clone)]
struct Problem {
    message: String,
    label: String,
    help: Option<String>,
    spot: Option<Spot>,
    further: Vec<ConfigError>,
}

/// A place together with the text it lies in.
#[derive(Debug, Clone)]
struct Spot {
    place: Place,
    manner: Manner,
    name: String,
    code: Option<NamedSource<Arc<str>>>,
    line: usize,
    column: usize,
}

impl ConfigError {
    /// An error that no line is to blame for.
    pub fn new(message: impl Into<String>) -> Self {
        let message = message.into();
        Self(Box::new(Problem { message, label: "here".to_owned(), help: None, spot: None, further: Vec::new() }))
    }

    /// An error found after loading, pointed at where the value of `key` (`a.b.c`) was written.
    ///
    /// A value that is a default is pointed at by the innermost table around it that somebody wrote.
    pub fn at(resolved: &Resolved, key: &str, message: impl Into<String>) -> Self {
        let (place, written) = resolved.find(key);
        let error = Self::new(message).spotted(resolved.sources(), place).labelled(format!("`{key}`"));
        if written { error } else { error.helped(format!("`{key}` is not written anywhere: its default was used")) }
    }

    pub(super) fn spotted(mut self, sources: &Sources, place: Option<Place>) -> Self {
        self.0.spot = place.map(|place| {
            let source = sources.of(place);
            let (line, column) = line_and_column(&source.text, place.start);
            let drawn = source.text.lines().nth(line - 1).is_none_or(|text| text.len() <= DRAWN_LINE);
            let code = drawn.then(|| NamedSource::new(&source.name, Arc::clone(&source.text)));
            Spot { place, manner: source.manner, name: source.name.clone(), code, line, column }
        });
        self
    }

    pub(super) fn labelled(mut self, label: impl Into<String>) -> Self {
        self.0.label = label.into();
        self
    }

    pub(super) fn helped(mut self, help: impl Into<String>) -> Self {
        self.0.help = Some(help.into());
        self
    }

    /// One error of several, or nothing when there are none.
    pub(super) fn all(problems: Vec<ConfigError>) -> Result<(), Self> {
        let mut problems = problems.into_iter();
        let Some(mut first) = problems.next() else { return Ok(()) };
        first.0.further.extend(problems);
        Err(first)
    }

    /// Drawn with colours and frames where the terminal has them.
    pub fn graphical(&self) -> String {
        let mut drawn = String::new();
        match GraphicalReportHandler::new().render_report(&mut drawn, self) {
            Ok(()) => drawn,
            Err(_) => self.plain(),
        }
    }

    /// Drawn in plain text: the sentence, the line with a caret under the culprit, and the advice.
    pub fn plain(&self) -> String {
        let problem = &self.0;
        let mut drawn = format!("{self}\n");
        if let Some(spot) = &problem.spot
            && let Some(code) = &spot.code
        {
            let line = code.inner().lines().nth(spot.line - 1).unwrap_or("").replace('\t', " ");
            let rest = line.chars().count().saturating_sub(spot.column - 1);
            let width = code.inner().get(spot.place.start..spot.place.end).map_or(1, |text| text.chars().count());
            let gutter = " ".repeat(spot.line.to_string().len());
            let (indent, carets) = (" ".repeat(spot.column - 1), "^".repeat(width.min(rest).max(1)));
            drawn += &format!("{gutter} |\n{} | {line}\n{gutter} | {indent}{carets} {}\n", spot.line, problem.label);
        }
        if let Some(help) = &problem.help {
            drawn += &format!("  help: {help}\n");
        }
        for further in &problem.further {
            drawn += &format!("\n{}", further.plain());
        }
        drawn
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0.spot {
            Some(Spot { name, manner: Manner::File, line, column, .. }) => write!(f, "{name}:{line}:{column}: ")?,
            Some(Spot { name, .. }) => write!(f, "{name}: ")?,
            None => {}
        }
        f.write_str(&self.0.message)
    }
}

impl std::error::Error for ConfigError {}

impl Diagnostic for ConfigError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.0.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.spot.as_ref()?.code.as_ref().map(|code| code as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let place = self.0.spot.as_ref()?.place;
        let span = SourceSpan::from((place.start, place.end - place.start));
        Some(Box::new(std::iter::once(LabeledSpan::new_with_span(Some(self.0.label.clone()), span))))
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.0.further.iter().map(|further| further as &dyn Diagnostic)))
    }
}
