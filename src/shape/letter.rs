//! Letters: the glyphs of the Hack font as plane figures.
use super::extruded::{Extruded, Outline, positive};
use anyhow::{Context, ensure};
use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Pixels per em of the raster that stands for a glyph: on a letter 6 cm high a pixel is about 0.2 mm.
const PIXELS: f32 = 400.0;

/// A letter lying on the table, its foot toward −y.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LetterSpec {
    /// One character of the Hack font, for example "B".
    pub character: char,
    /// Extent of the glyph along y \[m\].
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub height: f64,
    /// Extent along x \[m\]; the font's own proportions unless given.
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub width: Option<f64>,
    /// Extent along z \[m\]; this or `volume`.
    #[schemars(range(min = 1e-5, max = 10.0))]
    pub thickness: Option<f64>,
    /// Volume \[m³\]; this or `thickness`.
    #[schemars(range(min = 1e-12, max = 100.0))]
    pub volume: Option<f64>,
}

impl LetterSpec {
    pub(crate) fn build(self) -> anyhow::Result<Extruded<Glyph>> {
        let mut glyph = letter(self.character, positive("height", self.height)?)?;
        if let Some(width) = self.width {
            glyph.half.x = positive("width", width)? / 2.0;
        }
        Extruded::new(glyph, self.thickness, self.volume)
    }
}

/// The ink of one character.
#[derive(Clone, Debug, PartialEq)]
pub struct Glyph {
    /// Half of its width and height \[m\].
    pub half: DVec2,
    columns: usize,
    /// Whether a pixel has ink, row by row from the top.
    ink: Vec<bool>,
}

/// The Hack font (regular), which ships with a crate.
///
/// # Errors
/// When that font cannot be read.
pub(crate) fn hack() -> anyhow::Result<fontdue::Font> {
    let font = fontdue::Font::from_bytes(epaint_default_fonts::HACK_REGULAR, fontdue::FontSettings::default());
    font.map_err(anyhow::Error::msg).context("the font that ships with epaint cannot be read")
}

/// The glyph of `character` in the Hack font (regular), `height` \[m\] tall from its lowest to its highest ink.
///
/// # Errors
/// When the font lacks the character, or the character has no ink.
pub fn letter(character: char, height: f64) -> anyhow::Result<Glyph> {
    let font = hack()?;
    ensure!(font.has_glyph(character), "the Hack font has no {character:?}; choose another character");
    let (metrics, coverage) = font.rasterize(character, PIXELS);
    let covered = |i: usize| coverage[i] >= 128;
    let full = (0..coverage.len()).filter(|&i| covered(i)).map(|i| (i % metrics.width, i / metrics.width));
    let (low, high) = full.fold(((usize::MAX, usize::MAX), (0, 0)), |(l, h), (x, y)| {
        ((l.0.min(x), l.1.min(y)), (h.0.max(x + 1), h.1.max(y + 1)))
    });
    ensure!(low.0 < high.0, "{character:?} has no ink; choose a visible character");
    let (columns, rows) = (high.0 - low.0, high.1 - low.1);
    let ink = (0..columns * rows).map(|i| covered((low.1 + i / columns) * metrics.width + low.0 + i % columns));
    let half = DVec2::new(height * columns as f64 / rows as f64, height) / 2.0;
    Ok(Glyph { half, columns, ink: ink.collect() })
}

impl Outline for Glyph {
    fn covers(&self, at: DVec2) -> bool {
        let rows = self.ink.len() / self.columns;
        let place = (at / self.half + 1.0) / 2.0;
        let (x, y) = (place.x * self.columns as f64, (1.0 - place.y) * rows as f64);
        let inside = (0.0..self.columns as f64).contains(&x) && (0.0..rows as f64).contains(&y);
        inside && self.ink[y as usize * self.columns + x as usize]
    }

    fn half(&self) -> DVec2 {
        self.half
    }

    fn area(&self) -> f64 {
        let share = self.ink.iter().filter(|&&ink| ink).count() as f64 / self.ink.len() as f64;
        4.0 * self.half.element_product() * share
    }
}
