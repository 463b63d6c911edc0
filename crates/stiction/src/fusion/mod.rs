//! The frozen model that makes probabilities and intervals of evidence.
