//! `vn100 replay`: recorded captures through the pipeline, one result each, in the order given.

mod shown;

use anyhow::Result;

use crate::{
    args::ReplayArgs,
    exit::Exit,
    files::{EachSecond, measure_files},
    teller::Teller,
};

pub(crate) fn replay(args: &ReplayArgs) -> Result<Exit> {
    let files = &args.files;
    if let Some(speed) = args.speed {
        return shown::replay_shown(files, speed);
    }
    let each_second = if files.measure.ndjson { EachSecond::Printed } else { EachSecond::Unseen };
    let mut teller = Teller::new(files.measure.telling());
    measure_files(files, each_second, |measured| teller.tell(&measured))?;
    teller.finish()
}
