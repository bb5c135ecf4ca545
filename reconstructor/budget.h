// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/capture.h"
#include "common/geometry/mesh.h"
#include "reconstructor/evaluation/tradeoff_wish.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"

namespace sheen {

/// "0.01" or "40dB" (the same): Frobenius norm of what a ring may lose, relative to that of its columns. Throws
/// ConfigError naming --tolerance and what it takes.
double parse_tolerance(const std::string& word);
/// The relative error of so many decibels below the signal.
double tolerance_of(double decibels);

/// A rung of the ladder from the given settings to the quickest ones.
struct Rung {
  double map_scale;  ///< of the side of surface maps
  int max_rank;      ///< terms displayed, at most
  double spare;      ///< terms kept inside for each of these, at most; 0 = as asked
  double cost;       ///< processor time of an image, relative to the first rung
  double loss_db;    ///< of held-out PSNR against the first rung
};
/// Each costs less than the one before; cost and loss as `measure_pipeline` prints them (docs/decisions/budget.md).
std::span<const Rung> effort_ladder();
/// The options with a rung's limits laid on them.
SurfaceLightFieldOptions at_rung(const SurfaceLightFieldOptions& options, int rung);

/// Settings from the cheapest to the most accurate: the rungs, and what goes beyond the settings asked for. Where a
/// PSNR is to be reached.
std::vector<SurfaceLightFieldOptions> accuracy_ladder(const SurfaceLightFieldOptions& asked);

/// What rings are cut down to, step by step, when they outgrow the memory that they may take.
struct TermLimit {
  int max_rank, internal_rank, block;  ///< as in RingFactorOptions
};
std::span<const TermLimit> memory_steps();
/// The rung, `first` or a coarser one, with the finest maps of which the memory can hold at least eight terms whatever
/// comes; the last one when it can of none.
int finest_rung(const Mesh& mesh, const Capture& first_capture, const SurfaceLightFieldOptions& options, int first,
                double bytes);

/// Upper bound of the rings' memory once every ring holds all the terms and views that the options allow.
double largest_bytes(const Mesh& mesh, const Capture& first, const SurfaceLightFieldOptions& options);

/// Keeps the time of an image within a budget: a rung for the whole capture, chosen from the first images; after that
/// the share of rings that an image updates. What was decided is recorded, so that the model stays a function of the
/// captures and the record: with the record of an earlier run, the same captures give the same bits.
class EffortControl {
 public:
  static constexpr std::uint64_t kProbeImages = 8;  ///< updates that are timed before the rung is chosen

  explicit EffortControl(double image_ms) : budget_ms_(image_ms) {}
  /// Goes on from the record of an earlier run, in which `captures` had come. Throws ConfigError when it is no record.
  EffortControl(double image_ms, const std::string& record, std::uint64_t captures);

  double budget_ms() const { return budget_ms_; }
  std::optional<int> rung() const { return rung_; }  ///< nothing until it is chosen
  void set_rung(int rung) { rung_ = rung; }
  /// The cheapest need be: the first rung from `least` on that keeps the budget when the rung in use takes `image_ms`.
  int choose_rung(double image_ms, int in_use, int least) const;

  /// Share of the rings that capture number `capture` may update.
  double share(std::uint64_t capture) const;
  /// The update of a capture took so long: decides for the captures after it, unless the record speaks of them.
  void observe(std::uint64_t capture, double update_ms);
  /// Captures up to this number are to be treated as they were.
  void follow_record_until(std::uint64_t captures);

  std::string record() const;

 private:
  void set_level(std::uint64_t from, int level);

  double budget_ms_;
  std::optional<int> rung_;
  std::map<std::uint64_t, int> level_from_;  ///< a capture: from it on, which share
  std::uint64_t recorded_ = 0;
  double sum_ms_ = 0;
  int timed_ = 0;
};

}  // namespace sheen
