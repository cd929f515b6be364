//! Bags of ROS: messages of many topics with their times. ROS 1 bags, rosbag2's SQLite and MCAP
//! files, and folders of these.
//!
//! A [`Bag`] gives the messages in the order in which they were written, for every form of file; a
//! [`TopicScan`] finds the topics, and [`choose`] picks the topics of a sensor. [`BagSamples`]
//! makes samples of one topic: from the sentences inside its messages, or from their numbers.
//!
//! The readers of the forms take `Read + Seek`; only `open` and `folder` open files of the
//! operating system.

mod definition;
mod files;
mod folder;
mod mcap;
mod message_reader;
mod numbers;
mod open;
mod ros1;
mod rosbag2;
mod samples;
mod sentences;
mod sqlite;
mod standard_types;
mod streams;
mod structure;
mod topic;
mod topic_scan;

pub use self::files::BagForm;
pub(crate) use self::{
    files::Bag,
    open::{Stream, check_log, detect_bag, form_of},
    samples::BagSamples,
    streams::choose,
};
