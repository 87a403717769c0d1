//! The config of an identification.
use super::identify::Identifier;
use super::search::{Cone, SearchSpec};
use anyhow::Context;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How constants are fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IdentifySpec {
    /// Paths into the model's config, such as `laws.contact.stiffness`, with lower and upper bound in the constant's unit.
    pub constants: IndexMap<String, [f64; 2]>,
    /// What these constants may be beside each other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cones: Vec<ConeSpec>,
    /// Paths into the model's config of what is left out of it while its constants are sought, such as `corrections`: laws are then
    /// judged by their own prediction.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub leave_out: Vec<String>,
    /// Sets of constants that may be tried, a gradient counting as many as its price.
    #[schemars(range(min = 12))]
    pub evaluations: usize,
    /// Windows of the training episodes that each is tried on.
    #[schemars(range(min = 1))]
    pub windows: usize,
    /// Control steps of a window.
    #[schemars(range(min = 1))]
    pub horizon: usize,
    /// Displacement per control step above which a particle counts as moving \[m\].
    #[schemars(range(min = 0.0))]
    pub motion: f64,
    /// First standard deviation of the search, as a fraction of the logarithmic width of the bounds.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub sigma: f64,
    /// Seed of the search.
    pub seed: u64,
    /// How the constants are looked for.
    #[serde(default, skip_serializing_if = "SearchSpec::is_default")]
    pub search: SearchSpec,
    /// Searches that share the evaluations, the first from the model's own constants, the others from random ones.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[schemars(range(min = 1))]
    pub starts: usize,
}

/// `|(constants of "of")| ≤ factor · (constant "within")`, such as a friction along two axes below that of a third contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConeSpec {
    /// Path of the constant that bounds, one of `constants`.
    pub within: String,
    /// Paths of those that are bounded together, likewise.
    pub of: Vec<String>,
    /// How many times the bounding constant.
    #[serde(default = "unity", skip_serializing_if = "is_unity")]
    pub factor: f64,
}

fn unity() -> f64 {
    1.0
}

fn is_unity(value: &f64) -> bool {
    *value == 1.0
}

fn one() -> usize {
    1
}

fn is_one(value: &usize) -> bool {
    *value == 1
}

impl IdentifySpec {
    /// Checks the values.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub fn build(self) -> anyhow::Result<Identifier> {
        anyhow::ensure!(!self.constants.is_empty(), "`constants` of the identification is empty; name at least one");
        for (path, [low, high]) in &self.constants {
            let log = *low > 0.0 && high > low && high.is_finite();
            anyhow::ensure!(log, "the bounds of `{path}` are [{low}, {high}]; give 0 < low < high");
        }
        let counts = [
            ("evaluations", self.evaluations),
            ("windows", self.windows),
            ("horizon", self.horizon),
            ("starts", self.starts),
        ];
        for (key, value) in counts {
            anyhow::ensure!(value > 0, "`{key}` of the identification is 0; give at least 1");
        }
        let inside = self.sigma > 0.0 && self.sigma <= 1.0;
        anyhow::ensure!(inside, "`sigma` of the identification is {}; give a number from 0 to 1", self.sigma);
        let cones = self.cones.iter().map(|cone| self.cone(cone)).collect::<anyhow::Result<_>>()?;
        let search = self.search.clone().build()?;
        Ok(Identifier { spec: self, cones, search })
    }

    fn cone(&self, cone: &ConeSpec) -> anyhow::Result<Cone> {
        let place = |path: &String| {
            let known = || self.constants.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            let found = self.constants.get_index_of(path);
            found.with_context(|| format!("`cones` names `{path}`, which `constants` does not; there is {}", known()))
        };
        let ConeSpec { within, of, factor } = cone;
        anyhow::ensure!(!of.is_empty(), "a cone within `{within}` has an empty `of`; name what is to be bounded");
        anyhow::ensure!(
            *factor > 0.0 && factor.is_finite(),
            "the cone within `{within}` has the factor {factor}; give a positive number"
        );
        Ok(Cone { axis: place(within)?, of: of.iter().map(place).collect::<anyhow::Result<_>>()?, factor: *factor })
    }
}
