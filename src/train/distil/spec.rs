//! The config of a distillation.
use super::Distiller;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the messages of a learned pair law are read back as formulas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DistilSpec {
    /// Populations that breed apart and meet now and then.
    #[schemars(range(min = 1))]
    pub islands: usize,
    /// Formulas of each.
    #[schemars(range(min = 8))]
    pub population: usize,
    /// Generations of each.
    #[schemars(range(min = 1))]
    pub generations: usize,
    /// Most that a formula may hold: every variable, constant and operation counts one.
    #[schemars(range(min = 1))]
    pub complexity: usize,
    /// Control steps, of the episodes to fit to and of those to judge by, at whose starts messages are listened to.
    #[schemars(range(min = 1))]
    pub windows: usize,
    /// Meetings of each kind that formulas are fitted to, and as many that they are judged by.
    #[schemars(range(min = 16))]
    pub meetings: usize,
    /// Fraction of the training episodes of each tool that is not fitted to but used to choose a formula.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub validation: f64,
    /// Root mean square of a component of the messages, as a fraction of all components', below which it counts as dead and gets no
    /// formula.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub negligible: f64,
    /// Seed.
    pub seed: u64,
}

impl Default for DistilSpec {
    fn default() -> Self {
        Self {
            islands: 4,
            population: 64,
            generations: 40,
            complexity: 20,
            windows: 60,
            meetings: 2000,
            validation: 0.1,
            negligible: 0.02,
            seed: 0,
        }
    }
}

impl DistilSpec {
    /// Checks the values.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub fn build(self) -> anyhow::Result<Distiller> {
        let least = [
            ("islands", self.islands, 1),
            ("population", self.population, 8),
            ("generations", self.generations, 1),
            ("complexity", self.complexity, 1),
            ("windows", self.windows, 1),
            ("meetings", self.meetings, 16),
        ];
        for (key, value, least) in least {
            anyhow::ensure!(value >= least, "`{key}` of the distillation is {value}; give at least {least}");
        }
        for (key, value, most) in [("validation", self.validation, 0.9), ("negligible", self.negligible, 1.0)] {
            let inside = (0.0..=most).contains(&value);
            anyhow::ensure!(inside, "`{key}` of the distillation is {value}; give a number from 0 to {most}");
        }
        Ok(Distiller { spec: self })
    }
}
