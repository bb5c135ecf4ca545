// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/reconstructor/monitor/exposition_parser.h"
#include "tests/reconstructor/monitor/sample_state.h"

namespace sheen {
namespace {

using namespace std::chrono_literals;

Exposition exposition_of(const MonitorState& state, CaptureState capture = CaptureState::kLive) {
  return parse_exposition(metrics_text(state, capture, state.last_frame.value_or(MonitorState::Clock::now()) + 2s));
}

TEST(Metrics, SayWhatTheStateSays) {
  const Exposition metrics = exposition_of(sample_monitor_state());
  EXPECT_EQ(metrics.value("sheen_frames_received_total"), 160);
  EXPECT_EQ(metrics.value("sheen_frames_accepted_total"), 121);
  EXPECT_EQ(metrics.value("sheen_frames_held_out_total"), 13);
  EXPECT_EQ(metrics.value("sheen_frames_withdrawn"), 4);
  EXPECT_EQ(metrics.value("sheen_frames_journaled_total"), 159);
  EXPECT_EQ(metrics.value("sheen_frames_rejected_total", {{"reason", "object_not_in_view"}}), 17);
  EXPECT_EQ(metrics.value("sheen_frames_rejected_total", {{"reason", "exposure_unknown"}}), 9);
  EXPECT_EQ(metrics.value("sheen_tracker_frames_total"), 731);
  EXPECT_EQ(metrics.value("sheen_tracker_frames_refused_total", {{"reason", "motion_blur"}}), 422);
  EXPECT_EQ(metrics.value("sheen_tracker_trouble"), 1);
  EXPECT_EQ(metrics.value("sheen_ingest_images_per_second"), 8.4);
  EXPECT_EQ(metrics.value("sheen_update_duration_seconds_count"), 121);
  EXPECT_NEAR(metrics.value("sheen_update_duration_seconds_sum"), 0.001 * (60 * 121 + 121 * 61), 1e-9);
  EXPECT_NEAR(metrics.value("sheen_update_duration_seconds", {{"quantile", "0.5"}}), 0.121, 0.0013);
  EXPECT_NEAR(metrics.value("sheen_stage_duration_median_seconds", {{"stage", "factorize"}}), 0.0445, 1e-12);
  EXPECT_EQ(metrics.value("sheen_queue_depth", {{"queue", "send"}}), 31);
  EXPECT_EQ(metrics.value("sheen_queue_capacity", {{"queue", "send"}}), 64);
  EXPECT_TRUE(std::isnan(metrics.value("sheen_queue_capacity", {{"queue", "journal"}})));
  EXPECT_EQ(metrics.value("sheen_heldout_psnr_db"), 34.31);
  EXPECT_EQ(metrics.value("sheen_heldout_constant_psnr_db"), 28.87);
  EXPECT_EQ(metrics.value("sheen_heldout_ssim"), 0.9612);
  EXPECT_EQ(metrics.value("sheen_patches", {{"rank", "3"}}), 2210);
  EXPECT_EQ(metrics.value("sheen_model_bytes"), 48'200'000);
  EXPECT_EQ(metrics.value("sheen_link_connected", {{"link", "tracker"}, {"endpoint", "tcp://127.0.0.1:7410"}}), 1);
  EXPECT_EQ(metrics.value("sheen_capture_state", {{"state", "live"}}), 1);
  EXPECT_EQ(metrics.value("sheen_capture_state", {{"state", "stale"}}), 0);
  EXPECT_EQ(metrics.value("sheen_last_frame_age_seconds"), 2);
  EXPECT_EQ(metrics.value("sheen_info",
                          {{"version", "0.1.0"}, {"model", "surface-light-field"}, {"session", "/captures/teapot"}}),
            1);
}

TEST(Metrics, SayWhatIsTradedForWhat) {
  MonitorState state = sample_monitor_state();
  const Exposition metrics = exposition_of(state);
  EXPECT_EQ(metrics.value("sheen_effort_level"), 2);
  EXPECT_EQ(metrics.value("sheen_effort_levels"), 6);
  EXPECT_EQ(metrics.value("sheen_update_ratio"), 0.5);
  EXPECT_NEAR(metrics.value("sheen_budget_seconds"), 0.1, 1e-12);
  EXPECT_EQ(metrics.value("sheen_budget_kept"), 0);
  EXPECT_EQ(metrics.value("sheen_resident_memory_bytes"), 431e6);
  EXPECT_EQ(metrics.value("sheen_grown_memory_bytes"), 386e6);
  EXPECT_EQ(metrics.value("sheen_memory_limit_bytes"), 500e6);
  EXPECT_EQ(metrics.value("sheen_memory_kept"), 1);
  EXPECT_EQ(metrics.value("sheen_orthogonality_loss"), 3e-7);
  EXPECT_EQ(metrics.value("sheen_energy_loss_ratio"), 2.5e-4);
  state.trade = {};
  for (const char* family : {"sheen_budget_seconds", "sheen_budget_kept", "sheen_memory_limit_bytes",
                             "sheen_memory_kept", "sheen_orthogonality_loss", "sheen_energy_loss_ratio"})
    EXPECT_FALSE(exposition_of(state).types.contains(family)) << family << ": nobody asked for it, or it is not known";
}

TEST(Metrics, FollowTheNamingRules) {
  const Exposition metrics = exposition_of(sample_monitor_state());
  for (const auto& [family, type] : metrics.types) {
    EXPECT_TRUE(family.starts_with("sheen_")) << family;
    EXPECT_EQ(family.ends_with("_total"), type == "counter") << family;
    EXPECT_EQ(family.find("_ms"), std::string::npos) << family;
  }
  for (const ExpositionSample& sample : metrics.samples) EXPECT_TRUE(std::isfinite(sample.value)) << sample.name;
}

TEST(Metrics, LabelsSurviveWhateverTheyHold) {
  const std::string hostile = "a\"} 1\nsheen_frames_accepted_total 99999\\ {x=\"é";
  MonitorState state = sample_monitor_state();
  state.session_folder = hostile;
  state.refused = {{hostile, 3}};
  state.links[0].endpoint = hostile;
  const Exposition metrics = exposition_of(state);
  EXPECT_EQ(metrics.value("sheen_frames_rejected_total", {{"reason", hostile}}), 3);
  EXPECT_EQ(metrics.value("sheen_link_connected", {{"link", "tracker"}, {"endpoint", hostile}}), 1);
  EXPECT_EQ(metrics.value("sheen_frames_accepted_total"), 121);
}

TEST(Metrics, NothingKnownYetIsNoSampleRatherThanZero) {
  const Exposition metrics = exposition_of(MonitorState{}, CaptureState::kWaiting);
  EXPECT_FALSE(metrics.types.contains("sheen_heldout_psnr_db"));
  EXPECT_FALSE(metrics.types.contains("sheen_last_frame_age_seconds"));
  EXPECT_TRUE(std::isnan(metrics.value("sheen_update_duration_seconds", {{"quantile", "0.5"}})));
  EXPECT_EQ(metrics.value("sheen_update_duration_seconds_count"), 0);
  EXPECT_EQ(metrics.value("sheen_frames_received_total"), 0);
  EXPECT_EQ(metrics.value("sheen_capture_state", {{"state", "waiting"}}), 1);
}

TEST(Metrics, NonFiniteValuesAreSpelledAsTheFormatDoes) {
  MonitorState state = sample_monitor_state();
  state.held_out_curve.back().psnr_db = std::numeric_limits<double>::infinity();
  state.images_per_s = std::numeric_limits<double>::quiet_NaN();
  const Exposition metrics = exposition_of(state);
  EXPECT_EQ(metrics.value("sheen_heldout_psnr_db"), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(metrics.value("sheen_ingest_images_per_second")));
}

TEST(ExpositionParser, RefusesWhatTheFormatForbids) {
  for (const char* broken : {"a 1\n", "# TYPE a gauge\na 1", "# TYPE a gauge\na{b=\"c} 1\n", "# TYPE a gauge\na x\n",
                             "# TYPE a gauge\na 1\na 2\n", "# TYPE a gauge\na{b=\"\\x\"} 1\n",
                             "# TYPE a gauge\n# TYPE c gauge\na 1\nc 1\na{d=\"e\"} 1\n", "# TYPE a gauge\n9a 1\n"})
    EXPECT_THROW(parse_exposition(broken), std::exception) << broken;
}

}  // namespace
}  // namespace sheen
