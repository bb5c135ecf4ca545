// SPDX-License-Identifier: Apache-2.0
// Time of a frame while the eye moves; a model of about 12K triangles with maps of up to 16x16, or a saved one. Under
// Xvfb:
//   tests/support/with_xvfb build/bin/render_gl_bench [MODEL]
#include <benchmark/benchmark.h>

#include <chrono>
#include <string>
#include <vector>

#include "common/base/errors.h"
#include "reconstructor/models/surface_light_field/kind.h"
#include "reconstructor/render/gl/viewer_window.h"
#include "tests/reconstructor/render/gl/synthetic_light_field.h"

namespace sheen {
namespace {

std::string saved_model;  ///< empty: the synthetic one

std::shared_ptr<const ModelSnapshot> model() {
  static const std::shared_ptr<const ModelSnapshot> snapshot =
      saved_model.empty() ? SyntheticLightField({.around = 128, .across = 48}).snapshot()
                          : surface_light_field_kind().load(saved_model);
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

/// Frames as the window draws them while the mouse drags, as coarse as this machine asks for. Arguments: width, height.
/// A frame within 66 ms is 15 per second.
void drag(benchmark::State& bench) try {
  ViewerWindow window(
      surface_light_field_kind(),
      {.width = static_cast<int>(bench.range(0)), .height = static_cast<int>(bench.range(1)), .visible = false});
  ViewerState state;
  state.snapshot = model();
  for (int i = 0; i < 10; ++i) window.draw_soon(state);  // it learns what a frame takes
  for (auto _ : bench) {
    window.controls().orbit.orbit(0.1, 0);
    window.draw_soon(state);
  }
  bench.SetLabel(std::to_string(model()->mesh().triangles.size()) + " triangles, pixels of " +
                 std::to_string(window.pacer().frame().pixel).substr(0, 3));
} catch (const DeviceError& error) {
  bench.SkipWithError(error.what());
}
BENCHMARK(drag)->Args({1280, 800})->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond);

/// Opening a saved model: the label has the time until the mesh, the smooth part and all of it can be drawn.
void open_model(benchmark::State& bench) {
  if (saved_model.empty()) {
    bench.SkipWithError("needs a saved model: render_gl_bench MODEL");
    return;
  }
  std::vector<double> stage_ms;
  for (auto _ : bench) {
    const auto begun = std::chrono::steady_clock::now();
    stage_ms.clear();
    surface_light_field_kind().open(saved_model, [&](const auto&) {
      stage_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count());
    });
  }
  std::string label = "ms until each stage:";
  for (const double ms : stage_ms) label += " " + std::to_string(static_cast<int>(ms));
  bench.SetLabel(label);
}
BENCHMARK(open_model)->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond);

/// What a new snapshot costs: all patches of the model to the GPU, drawing included.
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

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (argc > 1) sheen::saved_model = argv[1];
  benchmark::RunSpecifiedBenchmarks();
}
