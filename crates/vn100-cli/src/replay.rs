//! `vn100 replay`: recorded captures through the pipeline, one result each, in the order given.

mod shown;

use anyhow::Result;

use crate::{
    args::ReplayArgs,
    datasheet::evaluation,
    exit::Exit,
    files::{EachSecond, measure_files},
    teller::Teller,
};

pub(crate) fn replay(args: &ReplayArgs) -> Result<Exit> {
    let files = &args.files;
    if let Some(speed) = args.speed {
        return shown::replay_shown(args, speed);
    }
    let evaluation = evaluation(&files.measure)?.with_filter_models(args.result.filter_models);
    let each_second = if args.result.ndjson { EachSecond::Printed } else { EachSecond::Unseen };
    let mut teller = Teller::new(args.result.telling());
    measure_files(files, evaluation, each_second, |measured| teller.tell(&measured))?;
    teller.finish()
}
