// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <functional>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "common/simulation/simulated_rig.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/figure_page.h"
#include "reconstructor/commands/study_options.h"
#include "reconstructor/scene/scene_mesh.h"
#include "reconstructor/studies/figure.h"
#include "reconstructor/studies/light_figures.h"
#include "reconstructor/studies/lumigraph_figures.h"

namespace sheen {
namespace {

constexpr int kFrames = 130, kWidth = 512, kHeight = 384;  // of the simulated rig

struct FiguresArguments {
  std::string dataset, mesh, out, rig, json;
  std::vector<int> only;
  bool quick = false, light = false, lumigraph = false;
  StudyOptions study;
};

/// The simulated rig as a data set, rendered when it is not there yet.
std::filesystem::path simulated_dataset(const FiguresArguments& arguments) {
  const std::filesystem::path folder =
      arguments.rig.empty() ? std::filesystem::path(arguments.out) / "rig" : std::filesystem::path(arguments.rig);
  Progress progress("rendering the simulated rig", kFrames);
  cached_recording({.frames = kFrames, .width = kWidth, .height = kHeight}, folder, [&](int done, int) {
    if (stop_requested()) throw Error("stopped while the simulated rig was rendered");
    progress.update(static_cast<std::uint64_t>(done));
  });
  return folder;
}

std::string thousands(std::size_t triangles) {
  return format("%.3gK", 1e-3 * static_cast<double>(triangles));
}

/// The paper's five sizes, bust to pitcher, of the demo's object; of a data set its own mesh alone.
std::vector<NamedMesh> meshes_for_timing(bool simulated, const std::shared_ptr<const Mesh>& mesh, bool quick) {
  if (!simulated) return {{thousands(mesh->triangles.size()), mesh}};
  std::vector<NamedMesh> meshes;
  for (const int triangles : {7000, 12000, 5000, 2700, 3000}) {
    if (quick && triangles > 3000) continue;
    meshes.push_back(
        {thousands(static_cast<std::size_t>(triangles)), std::make_shared<Mesh>(make_demo_mesh(triangles))});
  }
  return meshes;
}

/// Made when it is first asked for.
template <typename T>
class OnDemand {
 public:
  explicit OnDemand(std::function<T()> make) : make_(std::move(make)) {}
  const T& get() {
    if (!made_) made_ = std::make_unique<T>(make_());
    return *made_;
  }

 private:
  std::function<T()> make_;
  std::unique_ptr<T> made_;
};

/// Before experiments of simulated scenes alone. `numbers`: of the figures that there are.
void check_simulated(const FiguresArguments& arguments, const std::string& option, const std::vector<int>& numbers) {
  if (!arguments.dataset.empty() || !arguments.mesh.empty())
    throw ConfigError(option + ": its experiments are of simulated scenes; leave the data set out");
  for (const int number : arguments.only)
    if (std::count(numbers.begin(), numbers.end(), number) == 0) {
      std::string all;
      for (const int there : numbers) all += (all.empty() ? "" : ", ") + std::to_string(there);
      throw ConfigError("--only: with " + option + " there are figures " + all);
    }
}

/// Those of the reflected irradiance field (002).
void light_figures(const FiguresArguments& arguments) {
  check_simulated(arguments, "--light", {3, 5, 7});
  install_stop_signals();
  FigurePage page(arguments.out, "irradiance_results.md", arguments.only, arguments.json);
  LightFigureOptions options;
  if (arguments.quick) options = {.width = 80, .height = 60, .lamps = 4};
  page.make({{3, [&] { return figure_exposure_curves(options); }},
             {5, [&] { return figure_undersampling(options); }},
             {7, [&] { return figure_brushed_metals(options); }}},
            "# The irradiance field's experiments, run again\n");
}

/// Those of the intrinsic lumigraph (001), with as many lights and views as the paper's.
void lumigraph_figures(const FiguresArguments& arguments) {
  check_simulated(arguments, "--lumigraph", {3, 7, 8, 9, 10, 11, 12, 14});
  install_stop_signals();
  FigurePage page(arguments.out, "lumigraph_results.md", arguments.only, arguments.json);
  const auto rig_of = [&](int lights, int side, double gloss) {
    LightRigOptions rig{.lights = lights, .columns = side, .rows = side, .gloss = gloss};
    if (arguments.quick) rig.columns = rig.rows = 3, rig.width = 160, rig.height = 120;
    return rig;
  };
  OnDemand<StillLife> simple([&] { return StillLife(rig_of(7, 5, 0), nullptr); }),
      toys([&] { return StillLife(rig_of(7, 17, 0), nullptr); }),
      glossy([&] { return StillLife(rig_of(10, 16, 0.3), nullptr); });
  OnDemand<ShadowRow> row([&] { return shadows_between(simple.get(), 2); });
  page.make({{3, [&] { return figure_merged_depth(depths_by_light(LightRig(rig_of(9, 9, 0)))); }},
             {7, [&] { return figure_moved_masks(row.get()); }},
             {8, [&] { return figure_depth_shadows(simple.get()); }},
             {9, [&] { return figure_shadow_shapes(row.get()); }},
             {10, [&] { return figure_shadow_difference(row.get()); }},
             {11, [&] { return figure_light_between(toys.get(), 11); }},
             {12, [&] { return figure_light_between(glossy.get(), 12); }},
             {14, [&] { return figure_error_maps(toys.get()); }}},
            "# The intrinsic lumigraph's experiments, run again\n");
}

void figures(const FiguresArguments& arguments) {
  if (arguments.light && arguments.lumigraph)
    throw ConfigError("--light and --lumigraph are two papers; give one of them");
  if (arguments.light) return light_figures(arguments);
  if (arguments.lumigraph) return lumigraph_figures(arguments);
  for (const int number : arguments.only)
    if (number < 4 || number == 7 || number > 11)
      throw ConfigError("--only: figures 3, 7, 12 and 14 are of --light and --lumigraph");
  if (arguments.dataset.empty() != arguments.mesh.empty())
    throw ConfigError("a data set needs its --mesh; without both, the simulated rig is used");
  install_stop_signals();
  FigurePage page(arguments.out, "paper_results.md", arguments.only, arguments.json);
  const bool simulated = arguments.dataset.empty();
  const std::filesystem::path dataset =
      simulated ? simulated_dataset(arguments) : std::filesystem::path(arguments.dataset);
  CaptureSet captures = open_capture_set(dataset);
  const auto mesh = std::make_shared<Mesh>(
      load_mesh_and_warn(simulated ? dataset / "mesh.ply" : std::filesystem::path(arguments.mesh),
                         SurfaceLightFieldOptions{}, captures.cameras));
  captures = in_frame_at(mesh->origin, std::move(captures));
  Experiment experiment;
  {
    Progress progress("reading", captures.size);
    const auto read = [&](std::size_t i) {
      if (stop_requested()) throw Error("stopped before anything was measured");
      return captures.read(i);
    };
    experiment = load_experiment(mesh, captures.size, read, {.max_held_out = 8},
                                 [&](std::size_t done) { progress.update(done); });
  }
  FigureOptions options{.quick = arguments.quick};
  options.model.surface_map = arguments.quick ? 4 : 16;
  options.model.map_detail = 0;  // online and batch have the same maps
  options.model.patch.factor = {.max_rank = options.rank, .tolerance = 0};
  arguments.study.apply(options.model);

  OnDemand<BatchRun> batch(
      [&] { return build_batch(experiment, options, BatchFactorization::reference(options.model.patch.factor)); });
  const Figures all{
      {4, [&] { return figure_rank_error(batch.get(), options); }},
      {5, [&] { return figure_imputation(experiment, options); }},
      {8, [&] { return figure_online_and_batch(experiment, batch.get(), options); }},
      {9, [&] { return figure_time(experiment, meshes_for_timing(simulated, mesh, arguments.quick), options); }},
      {10, [&] { return figure_view_choice(experiment, options); }},
      {11, [&] { return figure_orders(experiment, batch.get(), options); }},
  };
  page.make(all, format("# The paper's experiments, run again\n\n%zu training images, %zu held-out views, rank %d.\n",
                        experiment.training.size(), experiment.held_out.size(), options.rank));
}

}  // namespace

void add_figures_command(Command& program) {
  auto arguments = std::make_shared<FiguresArguments>();
  Command command =
      program.subcommand("figures", "Runs the paper's experiments again and writes plots, tables and findings.");
  command.option("dataset", arguments->dataset,
                 "folder with transforms.json, a COLMAP model or a Sheen session; default: the simulated rig");
  command.option("--mesh", arguments->mesh, "PLY, OBJ or OFF in the dataset's frame");
  command.option("--out", arguments->out, "folder for paper_results.md and, in images/, plots and pictures").required();
  command.option("--rig", arguments->rig, "where the simulated rig is kept between runs; default: OUT/rig");
  command.option("--only", arguments->only, "numbers of the figures to make, as in the paper")
      .delimiter(',')
      .check(one_of({3, 4, 5, 7, 8, 9, 10, 11, 12, 14}));
  command.flag("--light", arguments->light,
               "those of the irradiance field's paper instead: a lamp moves over the simulated object");
  command.flag("--lumigraph", arguments->lumigraph,
               "those of the intrinsic lumigraph's paper instead: a simulated still life in several lights");
  command.flag("--quick", arguments->quick, "fewer orders, ranks and images, coarser maps");
  command.option("--json", arguments->json, "report to write; - for standard output");
  add_study_options(command, arguments->study);
  command.callback([arguments] { figures(*arguments); });
}

}  // namespace sheen
