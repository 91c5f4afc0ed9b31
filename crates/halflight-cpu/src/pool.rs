//! Tasks of the visibility backends: their size, and reusable working memory that outlasts frames.

use std::fmt;
use std::sync::{Mutex, PoisonError};

/// Most groups or chunks of neighbouring queries that one task answers. Their costs differ by more than ten
/// times, and threads that finish early would wait for longer tasks.
pub(crate) const TASK: usize = 16;

/// Objects that are not in use.
pub(crate) struct Pool<T>(Mutex<Vec<Box<T>>>);

impl<T> fmt::Debug for Pool<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Pool").finish_non_exhaustive()
    }
}

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Mutex::new(Vec::new()))
    }
}

impl<T> Pool<T> {
    /// Lends a task an unused object, or a new one. The object still holds the state of its previous task.
    pub(crate) fn lend<R>(&self, new: impl FnOnce() -> T, task: impl FnOnce(&mut T) -> R) -> R {
        let idle = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut lent = idle.unwrap_or_else(|| Box::new(new()));
        let result = task(&mut lent);
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(lent);
        result
    }
}
