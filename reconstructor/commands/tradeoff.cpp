// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/base/stop_signal.h"
#include "common/plot/plot.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/effort/effort_control.h"
#include "reconstructor/effort/limits.h"
#include "reconstructor/evaluation/evaluation_report.h"
#include "reconstructor/scene/scene_config.h"
#include "reconstructor/scene/scene_mesh.h"
#include "reconstructor/studies/patches.h"
#include "reconstructor/studies/precision.h"
#include "reconstructor/studies/small_files.h"
#include "reconstructor/studies/tradeoff.h"

namespace sheen {
namespace {

struct TradeoffArguments {
  std::string dataset, mesh, out, config, json, budget, target, memory;
  bool quick = false, parts = false;
};

/// Costs and worth of all points, and which of them no other one beats.
struct Frontiers {
  std::vector<double> time, cpu, bytes, psnr;
  std::vector<std::size_t> by_time, by_cpu, by_bytes;

  explicit Frontiers(const std::vector<TradeoffPoint>& points) {
    for (const TradeoffPoint& p : points) {
      time.push_back(p.image_ms);
      cpu.push_back(p.cpu_ms);
      bytes.push_back(p.bytes);
      psnr.push_back(p.psnr_db);
    }
    by_time = pareto_frontier(time, psnr);
    by_cpu = pareto_frontier(cpu, psnr);
    by_bytes = pareto_frontier(bytes, psnr);
  }
};

bool contains(const std::vector<std::size_t>& indices, std::size_t i) {
  return std::find(indices.begin(), indices.end(), i) != indices.end();
}

void print_table(const std::vector<TradeoffPoint>& points, const Frontiers& frontiers) {
  std::printf("%-34s %9s %9s %9s %6s %9s %7s  %s\n", "setting", "ms/image", "CPU ms", "MB", "rank", "PSNR dB", "SSIM",
              "frontier");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const TradeoffPoint& p = points[i];
    std::printf("%-34s %9.1f %9.1f %9.1f %6.1f %9.2f %7.4f  %s%s%s\n", p.setting.name.c_str(), p.image_ms, p.cpu_ms,
                p.bytes / 1e6, p.mean_rank, p.psnr_db, p.ssim, contains(frontiers.by_time, i) ? "time " : "",
                contains(frontiers.by_cpu, i) ? "CPU " : "", contains(frontiers.by_bytes, i) ? "bytes" : "");
  }
}

/// The frontier's points whose names find room beside each other.
std::vector<std::size_t> points_to_name(const std::vector<std::size_t>& frontier, const std::vector<double>& cost,
                                        const std::vector<TradeoffPoint>& points) {
  double lowest = points[frontier.front()].psnr_db, highest = lowest;
  for (const TradeoffPoint& p : points) {
    lowest = std::min(lowest, p.psnr_db);
    highest = std::max(highest, p.psnr_db);
  }
  std::vector<std::size_t> named;
  for (auto i = frontier.rbegin(); i != frontier.rend(); ++i) {  // the best ones first
    const bool room = std::all_of(named.begin(), named.end(), [&](std::size_t other) {
      return std::abs(points[*i].psnr_db - points[other].psnr_db) > 0.05 * (highest - lowest) ||
             std::abs(std::log10(cost[*i] / cost[other])) > 0.6;
    });
    if (room) named.push_back(*i);
  }
  return named;
}

Plot plot_against(const std::string& title, const std::string& cost_label, const std::vector<TradeoffPoint>& points,
                  const std::vector<double>& cost, const std::vector<std::size_t>& frontier, double scale) {
  Plot plot{.title = title, .x = {.label = cost_label, .log = true}, .y = {.label = "held-out PSNR (dB)"}};
  PlotSeries best{.name = "frontier", .style = PlotStyle::kLine};
  const std::vector<std::size_t> named = frontier.empty() ? frontier : points_to_name(frontier, cost, points);
  for (const std::size_t i : frontier) {
    best.add(scale * cost[i], points[i].psnr_db);
    best.labels.push_back(contains(named, i) ? points[i].setting.name : "");
  }
  plot.series.push_back(std::move(best));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::string& part = points[i].setting.part;
    auto series =
        std::find_if(plot.series.begin(), plot.series.end(), [&](const PlotSeries& s) { return s.name == part; });
    if (series == plot.series.end()) {
      plot.series.push_back({.name = part, .style = PlotStyle::kMarkers});
      series = plot.series.end() - 1;
    }
    series->add(scale * cost[i], points[i].psnr_db);
  }
  return plot;
}

void write_plots(const std::vector<TradeoffPoint>& points, const Frontiers& frontiers, const std::string& dataset,
                 const std::filesystem::path& out) {
  const std::string of = std::filesystem::path(dataset).filename().string();
  const PlotFiles time = write_plot(plot_against("Time against accuracy: " + of, "wall time per image (ms)", points,
                                                 frontiers.time, frontiers.by_time, 1),
                                    out / "tradeoff_time");
  write_plot(plot_against("Processor time against accuracy: " + of, "processor time per image (ms)", points,
                          frontiers.cpu, frontiers.by_cpu, 1),
             out / "tradeoff_cpu");
  write_plot(plot_against("Memory against accuracy: " + of, "memory of the model (MB)", points, frontiers.bytes,
                          frontiers.by_bytes, 1e-6),
             out / "tradeoff_bytes");
  if (time == PlotFiles::kTableOnly) std::fprintf(stderr, "%s\n", kInstallGnuplot);
}

void print_precision(const PrecisionStudy& study) {
  std::printf("\nnumber format, %zu columns of %zu patches of this scene\n", study.columns, study.patches);
  std::printf("%-34s %9s %9s %14s %22s\n", "", "us/column", "kB/patch", "relative error", "difference from double");
  for (const PrecisionRow* row : {&study.single, &study.twice, &study.stored, &study.stored_half}) {
    std::printf("%-34s ", row->name);
    if (row->column_us > 0)
      std::printf("%9.1f", row->column_us);
    else
      std::printf("%9s", "-");
    std::printf(" %9.1f %14.6f %22.1e\n", row->patch_bytes / 1e3, row->relative_error, row->difference);
  }
  std::printf("held-out PSNR: %.3f dB, with terms rounded to half %.3f dB\n", study.psnr_db, study.psnr_half_db);
}

nlohmann::json precision_to_json(const PrecisionStudy& study) {
  nlohmann::json rows = nlohmann::json::array();
  for (const PrecisionRow* row : {&study.single, &study.twice, &study.stored, &study.stored_half})
    rows.push_back({{"format", row->name},
                    {"column_us", row->column_us},
                    {"patch_bytes", row->patch_bytes},
                    {"relative_error", row->relative_error},
                    {"difference", row->difference}});
  return {{"patches", study.patches},
          {"columns", study.columns},
          {"formats", rows},
          {"psnr_db", study.psnr_db},
          {"psnr_half_db", study.psnr_half_db}};
}

void print_patches(const std::vector<PatchRow>& rows) {
  std::printf("\n%-34s %9s %12s %9s %9s %7s %6s\n", "triangles per patch", "patches", "factorize ms", "MB", "PSNR dB",
              "SSIM", "seam");
  for (const PatchRow& row : rows)
    std::printf("%-34d %9zu %12.1f %9.1f %9.2f %7.4f %6.3f\n", row.triangles, row.patches, row.factorize_ms,
                row.bytes / 1e6, row.psnr_db, row.ssim, row.seam);
}

nlohmann::json patches_to_json(const std::vector<PatchRow>& rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const PatchRow& row : rows)
    list.push_back({{"triangles", row.triangles},
                    {"patches", row.patches},
                    {"factorize_ms", row.factorize_ms},
                    {"bytes", row.bytes},
                    {"psnr_db", row.psnr_db},
                    {"ssim", row.ssim},
                    {"seam", row.seam}});
  return list;
}

void print_files(const std::vector<SmallFileRow>& rows) {
  std::printf("\n%-34s %9s %9s %9s %7s\n", "small file, dB that it may lose", "MB", "s", "PSNR dB", "SSIM");
  for (const SmallFileRow& row : rows)
    std::printf("%-34g %9.3f %9.1f %9.2f %7.4f\n", row.asked_db, static_cast<double>(row.bytes) / 1e6, row.seconds,
                row.psnr_db, row.ssim);
}

nlohmann::json files_to_json(const std::vector<SmallFileRow>& rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const SmallFileRow& row : rows)
    list.push_back({{"asked_db", row.asked_db},
                    {"bytes", row.bytes},
                    {"seconds", row.seconds},
                    {"psnr_db", row.psnr_db},
                    {"ssim", row.ssim}});
  return list;
}

Plot plot_files(const std::vector<SmallFileRow>& rows, const std::string& of) {
  Plot plot{.title = "Size of the file against accuracy: " + of,
            .x = {.label = "small file (MB)", .log = true},
            .y = {.label = "held-out PSNR (dB)"}};
  PlotSeries files{.name = "small file", .style = PlotStyle::kLine};
  for (const SmallFileRow& row : rows) {
    files.add(1e-6 * static_cast<double>(row.bytes), row.psnr_db);
    files.labels.push_back(format("%g dB", row.asked_db));
  }
  plot.series.push_back(std::move(files));
  return plot;
}

nlohmann::json point_to_json(const TradeoffPoint& p) {
  return {{"setting", p.setting.name}, {"part", p.setting.part}, {"image_ms", p.image_ms},
          {"cpu_ms", p.cpu_ms},        {"bytes", p.bytes},       {"mean_rank", p.mean_rank},
          {"psnr_db", p.psnr_db},      {"ssim", p.ssim},         {"scene", to_toml(p.setting.options)}};
}

/// The default, and the effort levels that stand from `first_level` on.
MeasuredLevels measured_levels(const std::vector<TradeoffPoint>& points, std::size_t first_level) {
  MeasuredLevels measured{{points.front().image_ms, points.front().psnr_db}};
  for (std::size_t i = first_level; i < points.size(); ++i) measured.push_back({points[i].image_ms, points[i].psnr_db});
  return measured;
}

Experiment read_experiment(const CaptureSet& captures, std::shared_ptr<const Mesh> mesh, int hold_out_every) {
  Progress progress("reading", captures.size);
  const auto read = [&](std::size_t i) {
    if (stop_requested()) throw Error("stopped before anything was measured");
    return captures.read(i);
  };
  return load_experiment(std::move(mesh), captures.size, read, {.hold_out_every = hold_out_every},
                         [&](std::size_t done) { progress.update(done); });
}

/// Of the settings in their order, those that were measured until the user stopped it.
std::vector<TradeoffPoint> measure_settings(const Experiment& experiment, const std::vector<Setting>& settings,
                                            PartsUntilStop& parts) {
  std::vector<TradeoffPoint> points;
  Progress progress("measuring", settings.size());
  for (const Setting& setting : settings) {
    std::optional<TradeoffPoint> point = parts.result([&] { return measure_setting(experiment, setting); });
    if (!point) break;
    points.push_back(*std::move(point));
    progress.update(points.size());
  }
  return points;
}

/// Of a light field with the settings that the sweep starts from.
struct Studies {
  PrecisionStudy precision;
  std::vector<PatchRow> patches;
  std::vector<SmallFileRow> files;
};

/// What the number format, the size of patches and that of the file cost and gain; nothing where the user stops it.
std::optional<Studies> study_base(const Experiment& experiment, const SurfaceLightFieldOptions& base,
                                  PartsUntilStop& parts) {
  return parts.result([&] {
    const OnlineRun light_field = build_online(experiment.mesh, experiment.in_order(), base);
    return Studies{study_precision(experiment, base, *light_field.model),
                   study_patches(experiment, base, std::array{1, 2, 4, 8, 16}),
                   study_small_files(experiment, *light_field.model, std::array{0.03, 0.1, 0.2, 0.3, 0.5, 1.0})};
  });
}

void add_studies(const Studies& studies, nlohmann::json& report) {
  print_precision(studies.precision);
  report["precision"] = precision_to_json(studies.precision);
  print_patches(studies.patches);
  report["patches"] = patches_to_json(studies.patches);
  print_files(studies.files);
  report["files"] = files_to_json(studies.files);
}

void write_scene(const std::filesystem::path& file, const SurfaceLightFieldOptions& base,
                 const MeasuredLevels& levels) {
  write_file(file,
             to_toml(base) + "\n# What --budget and --target can choose from, as measured.\n" + levels_to_toml(levels));
  std::printf("\n%s: give it to build or serve with --config; --budget and --target then use these figures\n",
              file.c_str());
}

nlohmann::json points_to_json(const std::vector<TradeoffPoint>& points, const Frontiers& frontiers, bool with_scenes) {
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t i = 0; i < points.size(); ++i) {
    nlohmann::json point = point_to_json(points[i]);
    if (!with_scenes) point.erase("scene");
    point["frontier_time"] = contains(frontiers.by_time, i);
    point["frontier_cpu"] = contains(frontiers.by_cpu, i);
    point["frontier_bytes"] = contains(frontiers.by_bytes, i);
    list.push_back(std::move(point));
  }
  return list;
}

nlohmann::json choose_and_print(const std::vector<TradeoffPoint>& points, const Limits& limits) {
  const TradeoffChoice choice = choose_setting(points, limits);
  const TradeoffPoint& chosen = points[choice.index];
  std::printf("\n%s: %s\n%.1f ms per image, %.1f MB, %.2f dB%s\n\n%s", describe(limits).c_str(),
              chosen.setting.name.c_str(), chosen.image_ms, chosen.bytes / 1e6, chosen.psnr_db,
              choice.holds ? "" : ": no measured setting keeps all limits; this one comes nearest",
              to_toml(chosen.setting.options).c_str());
  nlohmann::json json = point_to_json(chosen);
  json["holds"] = choice.holds;
  return json;
}

void tradeoff(const TradeoffArguments& arguments) {
  const Limits limits = parse_limits(arguments.budget, arguments.target, arguments.memory);
  install_stop_signals();
  ReportFile json(arguments.json);
  const SceneConfig scene = arguments.config.empty() ? default_scene() : load_scene_config(arguments.config);
  const SurfaceLightFieldOptions& base = light_field_options(*scene.settings, "tradeoff");
  const CaptureSet captures = open_capture_set(arguments.dataset);
  if (!arguments.out.empty()) {
    check_writable_folder(arguments.out);
    make_folder(arguments.out);
  }
  auto mesh = std::make_shared<Mesh>(load_mesh_and_warn(arguments.mesh, base, captures.cameras));
  const Experiment experiment = read_experiment(in_frame_at(mesh->origin, captures), mesh, base.hold_out_every);
  std::vector<Setting> settings = arguments.parts ? part_settings(base) : tradeoff_settings(base, arguments.quick);
  const std::size_t first_level = settings.size();
  if (!arguments.parts)
    for (Setting& setting : effort_level_settings(base)) settings.push_back(std::move(setting));

  PartsUntilStop parts;
  const std::vector<TradeoffPoint> points = measure_settings(experiment, settings, parts);
  if (parts.stopped()) std::fprintf(stderr, "stopped after %zu of %zu settings\n", points.size(), settings.size());
  if (points.empty()) return;

  const Frontiers frontiers(points);
  print_table(points, frontiers);
  // There are no keys in a scene file for what is built in.
  nlohmann::json report{{"training_images", experiment.training.size()},
                        {"held_out_views", experiment.held_out.size()},
                        {"points", points_to_json(points, frontiers, !arguments.parts)}};
  std::optional<Studies> studies;
  if (!parts.stopped() && !arguments.parts) studies = study_base(experiment, base, parts);
  if (studies) add_studies(*studies, report);
  if (!arguments.out.empty()) {
    write_plots(points, frontiers, arguments.dataset, arguments.out);
    if (studies)
      write_plot(plot_files(studies->files, std::filesystem::path(arguments.dataset).filename().string()),
                 std::filesystem::path(arguments.out) / "tradeoff_file");
    if (!arguments.parts && points.size() == settings.size())
      write_scene(std::filesystem::path(arguments.out) / "scene.toml", base, measured_levels(points, first_level));
  }
  if (!limits.empty()) report["choice"] = choose_and_print(points, limits);
  json.write(to_text(report));
}

}  // namespace

void add_tradeoff_command(Command& program) {
  auto arguments = std::make_shared<TradeoffArguments>();
  Command command = program.subcommand(
      "tradeoff",
      "Measures what each setting of the light field costs in time and memory and gains in held-out PSNR, on your own "
      "scene.");
  command.option("dataset", arguments->dataset, "folder with transforms.json, a COLMAP model or a Sheen session")
      .required();
  command.option("--mesh", arguments->mesh, "PLY, OBJ or OFF in the dataset's frame").required();
  command.option("--out", arguments->out,
                 "folder for the plots (SVG), their tables (CSV) and the scene file (TOML) with the effort levels of "
                 "--budget as measured");
  command.option("--config", arguments->config, "scene file (TOML) from which the sweep starts");
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.flag("--quick", arguments->quick, "three in five of the settings");
  Option parts = command.flag(
      "--parts", arguments->parts,
      "measure what each part of the model gains instead: without it, or with the paper's way in its place");
  const Option budget =
      command.option("--budget", arguments->budget, "name the best setting within a time per image, such as 33ms");
  const Option target = command.option("--target", arguments->target,
                                       "name the quickest setting that reaches a held-out PSNR, such as 35dB");
  const Option memory = command.option("--memory", arguments->memory,
                                       "name the best setting within a memory of the light field, such as 1GB");
  parts.excludes({budget, target, memory});
  command.callback([arguments] { tradeoff(*arguments); });
}

}  // namespace sheen
