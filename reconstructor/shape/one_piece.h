// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace sheen {

class SignBlocks;

/// Points are neighbours along the edges of Freudenthal's tetrahedra (six in each cube of the lattice, round the
/// diagonal from its lowest corner to its highest): 14 each.
struct PieceCounts {
  std::size_t cavities = 0;  ///< filled: pieces of the outside that do not reach the border
  std::size_t pieces = 0;    ///< of the inside, after that
  double left_out = 0;       ///< share of the points inside that were not of the largest piece
};

/// Fills cavities, then lays all pieces of the inside but the largest outside. What is left is one piece, and so is
/// what lies outside: the surface between them is one closed piece.
PieceCounts make_one_piece(SignBlocks& signs);

}  // namespace sheen
