//! Polygons of a file, in one array.

/// Faces as runs of faces of the same number of corners.
#[derive(Clone)]
pub(crate) struct Faces<C> {
    /// Corners of all faces.
    pub(crate) corners: Vec<C>,
    /// Numbers of corners, and the number of consecutive faces that have so many.
    runs: Vec<(usize, usize)>,
    count: usize,
}

impl<C> Default for Faces<C> {
    fn default() -> Self {
        Self { corners: Vec::new(), runs: Vec::new(), count: 0 }
    }
}

impl<C> Faces<C> {
    /// Number of faces.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Upper bound on the number of triangles of the faces.
    pub(crate) fn triangles(&self) -> usize {
        self.runs.iter().map(|&(corners, faces)| corners.saturating_sub(2) * faces).sum()
    }

    /// Turns the last `corners` corners into a face.
    pub(crate) fn end_face(&mut self, corners: usize) {
        self.add_run(corners, 1);
    }

    /// Appends a face.
    pub(crate) fn push(&mut self, corners: &[C])
    where
        C: Copy,
    {
        self.corners.extend_from_slice(corners);
        self.end_face(corners.len());
    }

    fn add_run(&mut self, corners: usize, faces: usize) {
        self.count += faces;
        match self.runs.last_mut() {
            Some((known, run)) if *known == corners => *run += faces,
            _ => self.runs.push((corners, faces)),
        }
    }

    /// Appends faces whose corners are mapped by a function.
    pub(crate) fn append<D>(&mut self, other: &Faces<D>, corner: impl FnMut(&D) -> C) {
        self.corners.extend(other.corners.iter().map(corner));
        for &(corners, faces) in &other.runs {
            self.add_run(corners, faces);
        }
    }

    /// Corners of every face.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[C]> {
        let mut rest = self.corners.as_slice();
        lengths(&self.runs).map_while(move |corners| rest.split_off(..corners))
    }

    /// Mutable corners of every face.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut [C]> {
        let mut rest = self.corners.as_mut_slice();
        lengths(&self.runs).map_while(move |corners| rest.split_off_mut(..corners))
    }
}

/// Number of corners of every face.
fn lengths(runs: &[(usize, usize)]) -> impl Iterator<Item = usize> {
    runs.iter().flat_map(|&(corners, faces)| std::iter::repeat_n(corners, faces))
}
