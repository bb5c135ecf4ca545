// SPDX-License-Identifier: Apache-2.0
// Time of a frame while the eye moves; a model of about 12K triangles with maps of up to 16x16. Under Xvfb:
//   tests/support/with_xvfb build/bin/render_gl_bench
#include <benchmark/benchmark.h>

#include "common/base/errors.h"
#include "reconstructor/models/surface_light_field/kind.h"
#include "reconstructor/render/gl/viewer_window.h"
#include "tests/reconstructor/render/gl/synthetic_light_field.h"

namespace sheen {
namespace {

std::shared_ptr<const SurfaceLightFieldSnapshot> model() {
  static const auto snapshot = SyntheticLightField({.around = 128, .across = 48}).snapshot();
  return snapshot;
}

/// Arguments: width, height, samples per pixel, mode.
void move_round(benchmark::State& bench) try {
  ViewerWindow window(surface_light_field_kind(), {.width = static_cast<int>(bench.range(0)),
                                                   .height = static_cast<int>(bench.range(1)),
                                                   .visible = false,
                                                   .samples = static_cast<int>(bench.range(2))});
  ViewerState state;
  state.snapshot = model();
  window.controls().mode = static_cast<ViewMode>(bench.range(3));
  window.draw_once(state);
  for (auto _ : bench) {
    window.controls().orbit.orbit(0.1, 0);
    benchmark::DoNotOptimize(window.draw_once(state));
  }
  bench.SetLabel(std::to_string(model()->mesh().triangles.size()) + " triangles, " + to_string(window.controls().mode));
} catch (const DeviceError& error) {
  bench.SkipWithError(error.what());
}
BENCHMARK(move_round)
    ->Args({640, 480, 1, 0})
    ->Args({1280, 800, 1, 0})
    ->Args({1280, 800, 4, 0})
    ->Args({1280, 800, 4, 1})
    ->Args({1280, 800, 4, 2})
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

/// What a new snapshot costs: all rings of the model to the GPU, drawing included.
void upload_everything(benchmark::State& bench) try {
  const SyntheticLightField light_field({.around = 128, .across = 48});
  ViewerWindow window(surface_light_field_kind(), {.width = 64, .height = 64, .visible = false, .samples = 1});
  ViewerState states[2];
  states[0].snapshot = light_field.snapshot();
  states[1].snapshot = light_field.with_other_bases();
  int turn = 0;
  for (auto _ : bench) benchmark::DoNotOptimize(window.draw_once(states[turn++ % 2]));
} catch (const DeviceError& error) {
  bench.SkipWithError(error.what());
}
BENCHMARK(upload_everything)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sheen

BENCHMARK_MAIN();
