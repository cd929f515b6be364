//! `vn100 replay`: recorded captures through the pipeline, one result each, in the order given.

use anyhow::Result;

use crate::{
    args::FileArgs,
    exit::Exit,
    files::{EachSecond, measure_files},
    measured::Teller,
};

pub(crate) fn replay(args: &FileArgs) -> Result<Exit> {
    let each_second = if args.measure.ndjson { EachSecond::Printed } else { EachSecond::Unseen };
    let mut teller = Teller::new(args.measure.telling());
    measure_files(args, each_second, |measured| teller.tell(&measured))?;
    teller.finish()
}
