//! The config of a model of particles under laws.
use super::{IntegratorSpec, ParticleModel};
use crate::graph::GraphSpec;
use crate::model::Checkpoints;
use crate::model::correction::CorrectionSpec;
use crate::model::law::LawSpec;
use anyhow::{Context, ensure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`ParticleModel`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticlesSpec {
    /// Substeps K of one control step \[1\].
    #[schemars(range(min = 1))]
    pub substeps: usize,
    /// Fraction of the velocity kept over one control step where nothing acts; 1 has no drag, 0 no inertia \[1\].
    #[schemars(range(min = 0.0, max = 1.0))]
    pub keep: f64,
    /// Share of the longest substep that the stiffest law bears which a substep takes at most: where it asks for more than `substeps`, so
    /// many are taken. Left out, `substeps` alone counts \[1\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3))]
    pub stability: Option<f64>,
    /// What takes particles through a substep.
    #[serde(default, skip_serializing_if = "IntegratorSpec::is_default")]
    pub integrator: IntegratorSpec,
    /// Which states of a rollout its gradient keeps.
    #[serde(default, skip_serializing_if = "Checkpoints::is_default")]
    pub checkpoints: Checkpoints,
    /// Numbers of the bodies that keep their shape.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid: Vec<u32>,
    /// Graph for the laws asked once a control step; needed only where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub graph: Option<GraphSpec>,
    /// Laws whose accelerations add up.
    #[serde(default)]
    pub laws: Vec<LawSpec>,
    /// What is done to the laws' prediction at the end of every control step, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub corrections: Vec<CorrectionSpec>,
}

impl ParticlesSpec {
    pub(crate) fn build(self) -> anyhow::Result<ParticleModel> {
        let place = |(i, law): (usize, LawSpec)| law.build().with_context(|| format!("in dynamics.laws[{i}]"));
        let names = self.laws.iter().map(LawSpec::called).collect();
        let laws = self.laws.into_iter().enumerate().map(place).collect::<Result<_, _>>()?;
        let graph = self.graph.map(GraphSpec::build).transpose()?;
        let place = |(i, correction): (usize, CorrectionSpec)| {
            correction.build().with_context(|| format!("in dynamics.corrections[{i}]"))
        };
        let corrections: Vec<_> = self.corrections.into_iter().enumerate().map(place).collect::<Result<_, _>>()?;
        ensure!(
            self.rigid.is_empty() || corrections.is_empty(),
            "dynamics.rigid names bodies that keep their shape, which dynamics.corrections would bend; leave one of them out"
        );
        let model = ParticleModel::new(self.substeps, self.keep, graph, laws)?;
        ParticleModel { rigid: self.rigid, names, checkpoints: self.checkpoints, ..model }
            .stable(self.stability)?
            .integrated(self.integrator)?
            .corrected(corrections)
    }
}
