//! The table of handles. A handle is a number that is never used again, so one that was freed, or that is of something
//! else, is told from a good one without touching any memory.

use crate::failure::{Failure, WireloomCode};
use std::any::Any;
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError, RwLock};

type Kept = Arc<dyn Any + Send + Sync>;

struct Table {
    last: u64,
    all: BTreeMap<u64, Kept>,
}

/// All that is shared by the functions of the library.
static TABLE: RwLock<Table> = RwLock::new(Table { last: 0, all: BTreeMap::new() });

fn bad(id: u64, what: &str) -> Failure {
    let message = if id == 0 { format!("no {what} was given") } else { format!("{id} is no {what}, or was freed") };
    Failure::new(WireloomCode::BadHandle, message, "give a handle that was not freed")
}

/// A new handle.
pub fn new<T: Any + Send + Sync>(object: T) -> u64 {
    let object = Arc::new(object);
    let mut table = TABLE.write().unwrap_or_else(PoisonError::into_inner);
    table.last += 1;
    let id = table.last;
    table.all.insert(id, object);
    id
}

/// What a handle stands for.
pub fn get<T: Any + Send + Sync>(id: u64, what: &str) -> Result<Arc<T>, Failure> {
    let found = TABLE.read().unwrap_or_else(PoisonError::into_inner).all.get(&id).cloned();
    found.and_then(|kept| kept.downcast().ok()).ok_or_else(|| bad(id, what))
}

/// Frees a handle. What it stands for stays until the calls that use it have ended. The handle 0 is none.
pub fn free<T: Any + Send + Sync>(id: u64, what: &str) -> Result<(), Failure> {
    if id == 0 {
        return Ok(());
    }
    get::<T>(id, what)?;
    let kept = TABLE.write().unwrap_or_else(PoisonError::into_inner).all.remove(&id);
    // Dropped here, when the table is no longer locked.
    kept.map(drop).ok_or_else(|| bad(id, what))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn handles_are_told_apart_by_what_they_stand_for_and_used_once() {
        let (number, word) = (new(7_u8), new("seven".to_owned()));
        assert_eq!(get::<u8>(number, "number").map(|own| *own).ok(), Some(7));
        for wrong in [get::<u8>(word, "number").err(), get::<u8>(0, "number").err(), free::<u8>(word, "number").err()] {
            assert_eq!(wrong.map(|failure| failure.code), Some(WireloomCode::BadHandle));
        }
        assert!(free::<u8>(number, "number").is_ok() && free::<u8>(0, "number").is_ok());
        assert!(free::<u8>(number, "number").is_err() && new(8_u8) > word);
    }
}
