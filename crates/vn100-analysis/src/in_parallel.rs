//! Work distributed over all cores.

use std::{
    num::NonZero,
    panic::resume_unwind,
    sync::{Mutex, PoisonError},
    thread,
};

/// The results of `work` on each of `items`, in the order of the items, whatever the number of
/// cores.
///
/// # Panics
/// With the panic of `work`, once all other items are done.
pub(crate) fn in_parallel<T, R: Send>(items: impl Iterator<Item = T> + Send, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    // no more threads than items
    let most = items.size_hint().1.unwrap_or(usize::MAX).saturating_sub(1);
    let queue = Mutex::new(items.enumerate());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work_off = || std::iter::from_fn(next).map(|(place, item)| (place, work(item))).collect::<Vec<_>>();
    let others = thread::available_parallelism().map_or(0, |cores| NonZero::get(cores) - 1).min(most);
    let mut done = thread::scope(|scope| {
        // where no further thread can be started, the work is done on this one
        let others: Vec<_> =
            (0..others).filter_map(|_| thread::Builder::new().spawn_scoped(scope, work_off).ok()).collect();
        let mut done = work_off();
        for other in others {
            done.extend(other.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
        done
    });
    done.sort_unstable_by_key(|(place, _)| *place);
    done.into_iter().map(|(_, result)| result).collect()
}

/// The results of both, on two threads unless no further one can be started.
pub(crate) fn both<A, B: Send>(one: impl FnOnce() -> A, other: impl Fn() -> B + Sync) -> (A, B) {
    thread::scope(|scope| match thread::Builder::new().spawn_scoped(scope, &other) {
        Ok(thread) => (one(), thread.join().unwrap_or_else(|panic| resume_unwind(panic))),
        Err(_) => (one(), other()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_order_of_the_items() {
        assert_eq!(in_parallel(0..1000_u32, |item| item * item), (0..1000).map(|item| item * item).collect::<Vec<_>>());
        assert_eq!(in_parallel(0..0_u32, |item| item), [0; 0]);
    }

    #[test]
    fn both_are_done() {
        assert_eq!(both(|| 1, || "two"), (1, "two"));
    }
}
