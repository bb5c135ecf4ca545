// SPDX-License-Identifier: Apache-2.0
#include "tests/reconstructor/monitor/sample_state.h"

#include <cmath>

namespace sheen {

MonitorState sample_monitor_state() {
  MonitorState state;
  state.version = "0.1.0";
  state.model = "surface-light-field";
  state.session_folder = "/captures/teapot";
  state.source_session = "rig-7";
  state.links = {{"tracker", "tcp://127.0.0.1:7410", true, true, "", true}};
  state.last_frame = MonitorState::Clock::now();
  state.received = 160;
  state.accepted = 121;
  state.held_out = 13;
  state.withdrawn = 4;
  state.waiting = 6;
  state.journaled = 159;
  state.refused = {{"object_not_in_view", 17}, {"exposure_unknown", 9}};
  state.tracker = {731, {{"motion_blur", 422}, {"too_near", 139}}, "too fast: motion blur"};
  state.images_per_s = 8.4;
  state.queues = {{"journal", {5, 0}}, {"send", {31, 64}}};
  state.stage_s = {{"visibility", 0.031}, {"resample", 0.027}, {"factorize", 0.0445}};
  RunningStatistics update, latency, model_latency, picture_latency;
  for (int i = 1; i <= 121; ++i) update.add(0.001 * (60 + i));
  for (int i = 1; i <= 160; ++i) latency.add(0.0002 * i);
  state.update = summarize(update);
  state.latency = summarize(latency);
  for (int i = 1; i <= 121; ++i) model_latency.add(0.002 * i);
  for (int i = 1; i <= 118; ++i) picture_latency.add(0.004 * i);
  state.model_latency = summarize(model_latency);
  state.picture_latency = summarize(picture_latency);
  state.rank_histogram = {14, 820, 1940, 2210, 870, 190, 33};
  state.surface = {.seen = 0.828, .measured = 0.79};
  state.shape = {.seen = 0.81, .outlined = 0.05, .guessed = 0.14};
  state.model_bytes = 48'200'000;
  state.trade = {.favour = "speed",
                 .effort_level = 2,
                 .effort_levels = 6,
                 .update_fraction = 0.5,
                 .image_ms = 121,
                 .budget_ms = 100,
                 .resident_bytes = 431e6,
                 .grown_bytes = 386e6,
                 .memory_bytes = 500e6,
                 .target_db = 35,
                 .health = {.orthogonality_lost = 3e-7, .energy_lost = 2.5e-4}};
  for (std::uint64_t n = 12; n <= 120; n += 4) {
    const double x = static_cast<double>(n);
    state.held_out_curve.push_back({.images = n,
                                    .psnr_db = 34.31 - 9.0 * std::exp(-x / 30) + 0.2 * std::sin(x),
                                    .ssim = 0.9612,
                                    .constant_psnr_db = 28.9 - 3.0 * std::exp(-x / 20)});
  }
  state.held_out_curve.back().psnr_db = 34.31;
  state.held_out_curve.back().constant_psnr_db = 28.87;
  state.preview_note = "no photograph from here: the nearest is 34 degrees away";
  state.next_view = "move the camera to the left of the object, lower";
  return state;
}

}  // namespace sheen
