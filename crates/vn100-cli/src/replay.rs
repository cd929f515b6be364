//! `vn100 replay`: recorded captures through the pipeline, one result each, in the order given.

mod in_view;

use anyhow::Result;

use crate::{
    args::ReplayArgs,
    datasheet::evaluation,
    exit::Exit,
    files::{EachSecond, measure_files},
    result_writer::ResultWriter,
};

pub(crate) fn replay(args: &ReplayArgs) -> Result<Exit> {
    let files = &args.files;
    if let Some(speed) = args.speed {
        return in_view::replay_in_view(args, speed);
    }
    let evaluation = evaluation(&files.measure)?.with_filter_models(args.result.filter_models);
    let each_second = if args.result.ndjson { EachSecond::Printed } else { EachSecond::Unseen };
    let mut writer = ResultWriter::new(args.result.format());
    measure_files(files, evaluation, each_second, |measured| writer.write(&measured))?;
    writer.finish()
}
