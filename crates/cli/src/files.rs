//! Files: scenarios that are read, folders of results that are written, and the program's own folder within them.

pub mod envelope;
pub mod folder;
pub mod history;
pub mod load;
pub mod own;
pub mod page;
pub mod place;
pub mod results;
pub mod saved;
pub mod swept;
