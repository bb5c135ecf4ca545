// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <string>

namespace sheen {

/// How soundly a model holds what images gave it. NaN where a model has no factorizations, or no image has come.
struct NumericalHealth {
  /// Largest entry of |B^T B - I| over the bases that were looked at. Of bases that are kept in 16 bits a value up to
  /// 2e-3 is sound.
  double orthogonality_lost = std::numeric_limits<double>::quiet_NaN();
  /// Of the squared norm of all columns, the fraction that the factorizations let go of; 0..1.
  double energy_lost = std::numeric_limits<double>::quiet_NaN();
};

/// What a model trades for what, at one moment: what was asked for beside what is. For those who watch.
struct Trade {
  std::string favour;          ///< the word that the limits follow from; empty: none
  int effort_level = 0;        ///< 0: all that the settings ask for
  int effort_levels = 1;       ///< that the model has; the last one is the quickest
  double update_fraction = 1;  ///< of what an image shows, how much it may update
  double image_ms = 0;         ///< median time of adding an image; 0 before the first
  std::optional<double> budget_ms;
  double resident_bytes = 0;  ///< of the process
  double grown_bytes = 0;     ///< of these, since there is a model
  std::optional<double> memory_bytes;
  std::optional<double> target_db;
  NumericalHealth health;

  /// Nothing where it was not asked for, or no image says yet.
  std::optional<bool> budget_kept() const {
    return budget_ms && image_ms > 0 ? std::optional(image_ms <= *budget_ms) : std::nullopt;
  }
  std::optional<bool> memory_kept() const {
    return memory_bytes && resident_bytes > 0 ? std::optional(grown_bytes <= *memory_bytes) : std::nullopt;
  }
};

}  // namespace sheen
