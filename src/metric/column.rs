//! Metrics that a config names, and how their numbers are read.
use super::{
    AlignedMetricSpec, Better, ChamferSpec, CoverageSpec, EmdSpec, InsideSpec, IouSpec, MatchedRmseSpec, Metric,
};
use serde::{Deserialize, Serialize};

family! {
    /// Every metric that a config can name.
    MetricSpec builds Box<dyn Metric> {
        Chamfer(ChamferSpec),
        Emd(EmdSpec),
        Rmse(MatchedRmseSpec),
        Iou(IouSpec),
        Coverage(CoverageSpec),
        Inside(InsideSpec),
        Aligned(AlignedMetricSpec),
    }
}

/// How the numbers of a metric are read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// See [`Metric::unit`].
    pub unit: String,
    /// See [`Metric::better`].
    pub better: Better,
}

impl Column {
    /// As `metric` has it.
    pub fn of(metric: &dyn Metric) -> Self {
        Self { unit: metric.unit().to_owned(), better: metric.better() }
    }
}
