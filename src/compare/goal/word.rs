//! Letters, one for every piece of material.
use super::{Goal, GoalMaker, SAMPLES, Source, samplings};
use crate::metric::Matching;
use crate::shape::{Extruded, Glyph, Shape, letter};
use crate::state::{Particles, stream};
use crate::tool::Workpiece;
use anyhow::{Context, ensure};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A text whose letter i is to be made of piece i of the scene, where that lies; a single letter is made of the only piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WordSpec {
    /// As many characters of the Hack font as the scene has pieces, for example "PLY".
    #[schemars(length(min = 1))]
    pub text: String,
    /// Extent of the letters along z \[m\]; each is as large as the volume of its piece allows.
    #[schemars(range(min = 1e-4, max = 1.0))]
    pub thickness: f64,
}

/// See [`WordSpec`].
pub(crate) struct Word(WordSpec);

impl WordSpec {
    pub(crate) fn build(self) -> anyhow::Result<Word> {
        ensure!(!self.text.is_empty(), "goal.text is empty; write at least one letter");
        ensure!(
            self.thickness > 0.0 && self.thickness <= 1.0,
            "goal.thickness is {} m; it must lie in (0, 1]",
            self.thickness
        );
        self.text.chars().try_for_each(|character| letter(character, 1.0).map(|_| ()))?;
        Ok(Word(self))
    }
}

/// A letter, the middle of its piece, and the number of that piece's particles.
type Placed = (Extruded<Glyph>, DVec3, usize);

impl Word {
    fn letters(&self, source: &Source<'_>) -> anyhow::Result<Vec<Placed>> {
        let (start, pieces) = (source.start.particles(), source.start.pieces());
        let volumes = source.start.volumes();
        let count = self.0.text.chars().count();
        ensure!(
            count == volumes.len(),
            "goal.text \"{}\" has {count} letters for a scene of {} pieces; each piece becomes one letter",
            self.0.text,
            volumes.len()
        );
        let place = |(number, (character, volume)): (usize, (char, f64))| {
            let own = start.positions.iter().zip(&pieces).filter(|(_, piece)| **piece == number).map(|(p, _)| *p);
            let own = Particles::at_rest(own.collect());
            let shape = sized(character, volume, self.0.thickness)?;
            Ok((shape, Workpiece::around(&own).centre, own.len()))
        };
        self.0.text.chars().zip(volumes).enumerate().map(place).collect()
    }
}

/// The letter of a volume \[m³\] and thickness \[m\].
///
/// # Errors
/// When the font lacks the character.
fn sized(character: char, volume: f64, thickness: f64) -> anyhow::Result<Extruded<Glyph>> {
    let area = Extruded::new(letter(character, 1.0)?, Some(1.0), None)?.volume();
    let height = (volume / (thickness * area)).sqrt();
    Extruded::new(letter(character, height)?, None, Some(volume)).with_context(|| format!("the letter {character:?}"))
}

impl GoalMaker for Word {
    fn make(&self, source: &Source<'_>) -> anyhow::Result<Goal> {
        let letters = self.letters(source)?;
        let sampling = |purpose: &[u64]| -> Vec<DVec3> {
            let mut rng = stream(source.seed, purpose);
            let points = |(shape, centre, count): &Placed| {
                shape.points(*count, &mut rng).into_iter().map(|p| p + *centre).collect::<Vec<_>>()
            };
            letters.iter().flat_map(points).collect()
        };
        let samplings = samplings(|k| sampling(&[SAMPLES, k]));
        Ok(Goal { points: sampling(&[SAMPLES]), matching: Matching::Unmatched, samplings })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_of_the_alphabet_has_the_volume_and_thickness_that_it_should() {
        for character in 'A'..='Z' {
            let shape = sized(character, 7.5e-5, 0.02).unwrap();
            assert!((shape.volume() / 7.5e-5 - 1.0).abs() < 1e-9, "{character}");
            assert!((shape.thickness / 0.02 - 1.0).abs() < 1e-3, "{character}: {} m", shape.thickness);
            let size = shape.bounds().1 - shape.bounds().0;
            assert!((0.03..0.2).contains(&size.x) && (0.06..0.2).contains(&size.y), "{character}: {size}");
        }
    }
}
