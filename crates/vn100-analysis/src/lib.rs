//! From batches of samples to statistics, and from these to an assessment of the sensor. Pure: no
//! task, no clock, no file.
//!
//! [`Analysis`] takes batches and gives a [`Snapshot`] of all numbers at any time; an
//! [`Assessment`] is what a snapshot says at one level of confidence. [`Datasheet`],
//! [`Comparison`], [`Plan`] and [`Goal`] build on both.

/// The statistics whose results snapshots and assessments hold.
pub use imu_noise as noise;
/// The time base whose reports snapshots hold.
pub use imu_noise::timebase;
/// The channels, quantities and batches that an analysis takes.
pub use vn100_protocol as protocol;

mod accumulate;
mod assessment;
mod averaging_times;
mod coast;
mod comparison;
mod datasheet;
mod end;
mod goal;
mod goals_decided;
mod hypothesis_tests;
mod in_parallel;
mod invalid_text;
mod motion;
mod noise_figure;
mod plan;
mod rate_change;
pub mod recorded_settings;
mod remedy;
mod result;
mod selftest;
mod sensor;
mod settings;
mod snapshot;
mod source_facts;
mod want;
mod warning;

pub use accumulate::{
    analysis::Analysis,
    fingerprint::Fingerprint,
    magnitude::Magnitude,
    recent::{Recent, Slot},
    temperature_record::TemperatureRecord,
};
pub use assessment::{
    Aliasing, Assessment, AxisTemperature, BEFORE_FILTER_S, ChannelAssessment, ChannelNoise, LEAST_EDF,
    LongTauValidity, NoGrade, OctaveAssessment, Onboard, RateShare, Stationarity, WhiteBudget, WindowFrom,
};
pub use averaging_times::AveragingTimes;
pub use coast::Coast;
pub use comparison::{
    AxisWhite, Caveat, CaveatKind, Chance, ChannelMeans, ComparedChannel, Comparison, NoPrediction, OctaveTest,
    Population, RankedRecord, Ranking, RecordMean, SameSamples, Spread, UnitValue, WhiteTest,
};
pub use datasheet::{Datasheet, DatasheetFigure, DecidedBy, FigureVerdict, Ratio, SheetOnboard};
pub use end::{End, Shortfall, StartCure};
pub use goal::Goal;
pub use goals_decided::GoalCheck;
pub use invalid_text::InvalidText;
pub use motion::Motion;
pub use noise_figure::NoiseFigure;
pub use plan::{Given, Plan, PlannedMessage, PlannedWant, PlanningError, TakenAt, TakenFrom};
pub use rate_change::RateChange;
pub use remedy::{Remedy, RemedyWords, Setting};
pub use result::{
    BlockValues, Budget, ChannelResult, ComparedSheet, Completion, Curve, Discrete, DriftResult, Drifting, Graded,
    History, InUnit, Inflation, LinkCounts, NoiseResult, Norm, ParameterResult, Parts, Point, SourceResult, Spectrum,
    Statistics, TemperatureResult, TimeBase, WALK_OF_FLICKER, angle_drift,
};
pub use selftest::{SelfTestCheck, SelfTestSuite, self_test};
pub use sensor::{SENSORS, axes_name, letter, sensor_name, sensor_of, uncompensated_message};
pub use settings::{DEFAULT_CONFIDENCE, DEFAULT_RATE_HZ, Settings};
pub use snapshot::{ChannelSnapshot, MissingFrom, Outages, PlaceMark, RateFrom, Snapshot, Timing};
pub use source_facts::{
    Device, EndKind, FileFacts, LinkFacts, LinkStatus, Playback, RecorderFacts, RecordingEndFacts, RecordingFacts,
    SourceFacts, Speed, utc,
};
pub use want::{Known, Want};
pub use warning::{Aspect, Doubt, Doubtful, Event, Finding, Happening, Peak, Rejected, Severity, Warning, WarningKind};
