//! A table of text cells, and the three ways it is printed.

/// A titled table: one header, rows of equal length, and notes below it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// What the table shows.
    pub title: String,
    /// Column titles.
    pub header: Vec<String>,
    /// Cells, row by row.
    pub rows: Vec<Vec<String>>,
    /// Sentences printed below.
    pub notes: Vec<String>,
}

impl Grid {
    /// Columns aligned with spaces, for a terminal.
    pub fn to_text(&self) -> String {
        let lines = || std::iter::once(&self.header).chain(&self.rows);
        let width = |c: usize| lines().map(|r| r[c].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.header.len()).map(width).collect();
        let print = |row: &Vec<String>| {
            let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, w)| format!("{cell:<w$}")).collect();
            cells.join("  ").trim_end().to_owned() + "\n"
        };
        let rule = "─".repeat(widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1)) + "\n";
        let mut text = format!("{}\n{}{rule}", self.title, print(&self.header));
        self.rows.iter().for_each(|row| text += &print(row));
        self.notes.iter().for_each(|note| text += &format!("  {note}\n"));
        text
    }

    /// A GitHub-flavoured Markdown table.
    pub fn to_markdown(&self) -> String {
        let line = |row: &[String]| {
            format!("| {} |\n", row.iter().map(|c| c.replace('|', "\\|")).collect::<Vec<_>>().join(" | "))
        };
        let mut text = format!("**{}**\n\n{}|{}\n", self.title, line(&self.header), " --- |".repeat(self.header.len()));
        self.rows.iter().for_each(|row| text += &line(row));
        self.notes.iter().for_each(|note| text += &format!("\n{note}\n"));
        text
    }

    /// A `tabular` with booktabs rules and the notes below it, to be `\input` by a paper.
    pub fn to_latex(&self) -> String {
        let line = |row: &[String]| row.iter().map(|c| escape(c)).collect::<Vec<_>>().join(" & ") + " \\\\\n";
        let columns = "l".repeat(self.header.len());
        let mut text =
            format!("% {}\n\\begin{{tabular}}{{{columns}}}\n\\toprule\n{}\\midrule\n", self.title, line(&self.header));
        self.rows.iter().for_each(|row| text += &line(row));
        text += "\\bottomrule\n\\end{tabular}\n";
        let notes = self.notes.iter().map(|note| format!("\n\\smallskip\\par {}\n", escape(note)));
        text + &notes.collect::<String>()
    }

    /// An HTML table.
    pub fn to_html(&self) -> String {
        let cells = |tag: &str, row: &[String]| {
            let cell = |c: &String| format!("<{tag}>{}</{tag}>", html_text(c));
            format!("<tr>{}</tr>\n", row.iter().map(cell).collect::<String>())
        };
        let body: String = self.rows.iter().map(|row| cells("td", row)).collect();
        let notes: String = self.notes.iter().map(|n| format!("<p class=\"note\">{}</p>\n", html_text(n))).collect();
        format!(
            "<h2>{}</h2>\n<table>\n<thead>{}</thead>\n<tbody>\n{body}</tbody>\n</table>\n{notes}",
            html_text(&self.title),
            cells("th", &self.header)
        )
    }
}

/// Text as HTML.
pub(super) fn html_text(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn escape(cell: &str) -> String {
    let special = |c: char| match c {
        '_' | '%' | '&' | '#' | '$' | '{' | '}' => format!("\\{c}"),
        '±' => "$\\pm$".to_owned(),
        '−' => "$-$".to_owned(),
        '→' => "$\\to$".to_owned(),
        'Δ' => "$\\Delta$".to_owned(),
        '∞' => "$\\infty$".to_owned(),
        '\\' => "\\textbackslash{}".to_owned(),
        _ => c.to_string(),
    };
    cell.chars().map(special).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        Grid {
            title: "Title".into(),
            header: vec!["model".into(), "cost".into()],
            rows: vec![vec!["a_b".into(), "1 ± 2".into()], vec!["<still>".into(), "−".into()]],
            notes: vec!["a & b".into()],
        }
    }

    #[test]
    fn text_columns_line_up() {
        let text = grid().to_text();
        let places: Vec<usize> =
            text.lines().filter(|l| l.contains("cost") || l.contains("±")).filter_map(|l| l.find(['c', '1'])).collect();
        assert_eq!(places.len(), 2);
        assert!(places.windows(2).all(|w| w[0] == w[1]), "{text}");
    }

    #[test]
    fn every_format_escapes_its_own_special_characters() {
        assert!(grid().to_latex().contains("a\\_b & 1 $\\pm$ 2 \\\\"));
        assert!(grid().to_html().contains("&lt;still&gt;"));
        assert_eq!(grid().to_markdown().matches('\n').count(), 8);
    }
}
