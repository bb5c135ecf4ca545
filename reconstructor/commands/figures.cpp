// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/base/stop_signal.h"
#include "common/image/image_io.h"
#include "common/simulation/simulated_rig.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/study_options.h"
#include "reconstructor/scene/scene_mesh.h"
#include "reconstructor/studies/figure.h"
#include "reconstructor/studies/light_figures.h"

namespace sheen {
namespace {

constexpr int kFrames = 130, kWidth = 512, kHeight = 384;  // of the simulated rig

struct FiguresArguments {
  std::string dataset, mesh, out, rig, json;
  std::vector<int> only;
  bool quick = false, light = false;
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

/// Pictures and tables of a figure into OUT/images; a section of the page.
std::string publish(const Figure& figure, const std::filesystem::path& out, bool& drawn) {
  std::string section = format("\n## Figure %d: ", figure.number) + figure.title + "\n\n";
  section += "| the paper | here | holds |\n|---|---|---|\n| " + figure.paper + " | " + figure.ours + " | " +
             (figure.holds ? "yes" : "**no**") + " |\n\n";
  for (const auto& [file, plot] : figure.plots) {
    drawn = write_plot(plot, out / "images" / file) == PlotFiles::kDrawn && drawn;
    section += "![" + plot.title + "](images/" + file + ".svg) ([table](images/" + file + ".csv))\n\n";
  }
  for (const Figure::Table& table : figure.tables) {
    write_file(out / "images" / (table.file + ".csv"), table_csv(table));
    section += table.caption + " ([table](images/" + table.file + ".csv)):\n\n" + table_markdown(table) + "\n";
  }
  for (const auto& [file, caption, image] : figure.pictures) {
    write_png(out / "images" / (file + ".png"), image);
    section += "![" + caption + "](images/" + file + ".png)\n*" + caption + "*\n\n";
  }
  return section;
}

using Figures = std::map<int, std::function<Figure()>>;

/// Makes those that are asked for and their page.
void make_figures(const Figures& all, const FiguresArguments& arguments, std::string page, const char* page_name,
                  ReportFile& report) {
  const std::filesystem::path out = arguments.out;
  nlohmann::ordered_json findings = nlohmann::ordered_json::array();
  bool drawn = true;
  PartsUntilStop parts;
  {
    Progress progress("measuring", all.size());
    std::size_t done = 0;
    for (const auto& [number, run] : all) {
      if (arguments.only.empty() || std::count(arguments.only.begin(), arguments.only.end(), number) > 0) {
        const std::optional<Figure> made = parts.result(run);
        if (!made) break;
        const Figure& figure = *made;
        page += publish(figure, out, drawn);
        findings.push_back({{"figure", number},
                            {"title", figure.title},
                            {"paper", figure.paper},
                            {"here", figure.ours},
                            {"holds", figure.holds}});
        const ProgressPause pause;
        std::printf("figure %d, %s: %s\n  the paper: %s\n  here: %s\n", number, figure.title.c_str(),
                    figure.holds ? "holds" : "DOES NOT HOLD", figure.paper.c_str(), figure.ours.c_str());
        std::fflush(stdout);
      }
      progress.update(++done);
    }
  }
  write_file(out / page_name, page);
  if (report.wanted()) report.write(nlohmann::ordered_json{{"figures", findings}}.dump(2) + "\n");
  if (!drawn) std::fprintf(stderr, "%s\n", kInstallGnuplot);
  if (parts.stopped()) std::fprintf(stderr, "stopped after %zu figures, which are kept\n", findings.size());
}

/// Those of the reflected irradiance field (002).
void light_figures(const FiguresArguments& arguments) {
  if (!arguments.dataset.empty() || !arguments.mesh.empty())
    throw ConfigError("--light: its experiments are of the simulated object; leave the data set out");
  for (const int number : arguments.only)
    if (number != 3 && number != 5 && number != 7)
      throw ConfigError("--only: with --light there are figures 3, 5 and 7");
  install_stop_signals();
  ReportFile report(arguments.json);
  check_writable_folder(arguments.out);
  make_folder(std::filesystem::path(arguments.out) / "images");
  LightFigureOptions options;
  if (arguments.quick) options = {.width = 80, .height = 60, .lamps = 4};
  make_figures({{3, [&] { return figure_exposure_curves(options); }},
                {5, [&] { return figure_undersampling(options); }},
                {7, [&] { return figure_brushed_metals(options); }}},
               arguments, "# The irradiance field's experiments, run again\n", "irradiance_results.md", report);
}

void figures(const FiguresArguments& arguments) {
  if (arguments.light) return light_figures(arguments);
  for (const int number : arguments.only)
    if (number == 3 || number == 7) throw ConfigError("--only: figures 3 and 7 are of --light");
  if (arguments.dataset.empty() != arguments.mesh.empty())
    throw ConfigError("a data set needs its --mesh; without both, the simulated rig is used");
  install_stop_signals();
  ReportFile report(arguments.json);
  const std::filesystem::path out = arguments.out;
  check_writable_folder(out);
  make_folder(out / "images");
  const bool simulated = arguments.dataset.empty();
  const std::filesystem::path dataset =
      simulated ? simulated_dataset(arguments) : std::filesystem::path(arguments.dataset);
  const CaptureSet captures = open_capture_set(dataset);
  const auto mesh = std::make_shared<Mesh>(
      load_mesh_and_warn(simulated ? dataset / "mesh.ply" : std::filesystem::path(arguments.mesh),
                         SurfaceLightFieldOptions{}, captures.cameras));
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
  options.model.patch.factor = {.max_rank = options.rank, .tolerance = 0};
  arguments.study.apply(options.model);

  std::unique_ptr<BatchRun> batch;
  const auto batch_run = [&]() -> const BatchRun& {
    if (!batch)
      batch = std::make_unique<BatchRun>(
          build_batch(experiment, options, BatchFactorization::reference(options.model.patch.factor)));
    return *batch;
  };
  const Figures all{
      {4, [&] { return figure_rank_error(batch_run(), options); }},
      {5, [&] { return figure_imputation(experiment, options); }},
      {8, [&] { return figure_online_and_batch(experiment, batch_run(), options); }},
      {9, [&] { return figure_time(experiment, meshes_for_timing(simulated, mesh, arguments.quick), options); }},
      {10, [&] { return figure_view_choice(experiment, options); }},
      {11, [&] { return figure_orders(experiment, batch_run(), options); }},
  };
  make_figures(all, arguments,
               format("# The paper's experiments, run again\n\n%zu training images, %zu held-out views, rank %d.\n",
                      experiment.training.size(), experiment.held_out.size(), options.rank),
               "paper_results.md", report);
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
      .check(one_of({3, 4, 5, 7, 8, 9, 10, 11}));
  command.flag("--light", arguments->light,
               "those of the irradiance field's paper instead: a lamp moves over the simulated object");
  command.flag("--quick", arguments->quick, "fewer orders, ranks and images, coarser maps");
  command.option("--json", arguments->json, "report to write; - for standard output");
  add_study_options(command, arguments->study);
  command.callback([arguments] { figures(*arguments); });
}

}  // namespace sheen
