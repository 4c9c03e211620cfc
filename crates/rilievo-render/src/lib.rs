//! rilievo-render
