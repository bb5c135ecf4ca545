// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/build.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/base/stop_signal.h"
#include "common/datasets/stored_images.h"
#include "reconstructor/capture/capture_report.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/live_shape.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/capture/training_images.h"
#include "reconstructor/commands/build_verdict.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/light_report.h"
#include "reconstructor/commands/mesh_choice.h"
#include "reconstructor/commands/shape_finding.h"
#include "reconstructor/effort/effort_control.h"
#include "reconstructor/evaluation/evaluation_report.h"
#include "reconstructor/scene/model_choice.h"
#include "reconstructor/scene/scene_mesh.h"

namespace sheen {
namespace {

/// The data set's model with these settings.
std::unique_ptr<Reconstruction> build_once(const BuildRequest& request, const ChosenMesh& chosen,
                                           const ModelSettings& settings, const Limits& limits,
                                           const MeasuredLevels& measured, int effort_level, bool first) {
  const CaptureSet& captures = chosen.captures;
  auto reconstruction = std::make_unique<Reconstruction>(chosen.mesh, settings);
  if (chosen.given) reconstruction->judge_on_pixels_of(std::make_shared<const RayPainter>(*chosen.given));
  if (chosen.poses_refined) reconstruction->note_poses();
  reconstruction->keep_within(limits, {}, 0, measured);
  reconstruction->expect_at_most(captures.size);
  if (effort_level > 0) reconstruction->begin_at(effort_level);
  {
    Progress progress("building", captures.size);
    for (std::size_t i = 0; i < captures.size; ++i) {
      if (stop_requested()) throw Error("stopped after " + std::to_string(i) + " images; no model was written");
      const Capture capture = captures.read(i);
      const IngestReport report = reconstruction->ingest(capture);
      if (first && report.status == IngestStatus::kRefused) {
        const ProgressPause pause;
        std::fprintf(stderr, "%s: not used: %s\n", capture.name.c_str(), report.reason.c_str());
      }
      progress.update(i + 1);
    }
  }
  reconstruction->leave_out(captures.withdrawn);
  reconstruction->refuse_damaged(captures.damaged);
  if (captures.size == 0 && captures.withdrawn > 0)
    throw FileError(request.dataset, "all of its images are withdrawn; `undo --restore` puts them back");
  const FrameCounts& counts = reconstruction->account().counts();
  if (counts.accepted == 0 && counts.held_out > 0)
    throw FileError(request.dataset, "all of its images that show the mesh are held out (" +
                                         std::to_string(counts.held_out) +
                                         "): nothing is left to build from; name fewer in test_filenames");
  if (counts.accepted == 0 && settings.makes_mesh())
    throw FileError(request.dataset, "none of its " + std::to_string(captures.size) +
                                         " images can be used: a model of moving light needs a light in each");
  if (counts.accepted == 0)
    throw FileError(request.dataset, "none of its " + std::to_string(captures.size) +
                                         " images shows the mesh; check that both are in the same frame and units");
  reconstruction->finish();
  return reconstruction;
}

/// Builds from the cheapest setting up until one reaches the PSNR asked for, or time or memory allow no dearer one;
/// then the best of those built.
std::unique_ptr<Reconstruction> build_to_target(const BuildRequest& request, const ChosenMesh& chosen,
                                                const ModelSettings& settings, const Limits& limits) {
  std::unique_ptr<Reconstruction> best;
  double best_db = 0;
  for (int level = settings.effort_levels() - 1; level >= 0; --level) {
    auto built = build_once(request, chosen, settings, limits, {}, level, !best);
    if (built->held_out().empty())
      throw ConfigError("--target needs held-out views to judge by: name test views or give --hold-out N");
    const double db = built->judge().model.psnr_db;
    // By time or memory: what comes next would be too.
    const bool bound = built->effort() != Reconstruction::Effort{.level = level};
    std::printf("effort level %d: %.2f dB, %.1f ms per image, %.0f MB\n", level, db,
                1e3 * built->account().updates().median_s(), static_cast<double>(built->model().figures().bytes) / 1e6);
    if (!best || db > best_db) {
      best = std::move(built);
      best_db = db;
    }
    if (best_db >= *limits.psnr_db || bound) break;
  }
  if (best_db < *limits.psnr_db)
    std::printf("no setting within the limits reaches %.2f dB; the best one is kept\n", *limits.psnr_db);
  return best;
}

/// What the model is built on where no mesh was given and the model makes none itself: the shape in the images.
Mesh found_shape(const BuildRequest& request, const CaptureSet& captures, int hold_out_every, nlohmann::json& report) {
  const std::optional<Mesh> rough = rough_mesh(request.from_mesh);
  if (const auto known = !rough && Session::exists(request.dataset) ? shape_of_session(request.dataset) : nullptr) {
    std::fprintf(stderr, "no --mesh: the shape is %s of the session\n", kShapeFile);
    return *known;
  }
  std::fprintf(stderr, "no --mesh: the shape is found in the images\n");
  try {
    return find_and_tell(training_images(captures, hold_out_every), {.from = rough ? &*rough : nullptr},
                         report["shape"])
        .mesh;
  } catch (const Error& error) {
    throw Error(std::string("no shape is found in the images: ") + error.what() + ". Or give --mesh");
  }
}

/// A bar, and the end of the work where it is to stop.
StepsDone saving() {
  return [bar = progress_bar("saving")](std::size_t done, std::size_t steps) {
    if (stop_requested()) throw Error("stopped while the model was saved; it was not written");
    bar(done, steps);
  };
}

/// What may be the cause of a model that failed, a sentence after a sentence.
std::string cause(const ChosenMesh& chosen) {
  if (!chosen.doubt.empty()) return ". The mesh: " + chosen.doubt;
  return ". Check that mesh and images are of one object, in the same frame and units";
}

}  // namespace

void build(BuildRequest request, const std::function<void(const nlohmann::json&)>& done) {
  Refining refining = refining_of(request.refine, request.no_refine);
  const SceneRequest asked(request.config, request.model);
  nlohmann::json fit = nlohmann::json::object();
  std::optional<CaptureSet> opened;
  const auto open = [&] {
    request.dataset = with_poses(request.dataset, request.object_size, request.mesh, fit);
    return open_capture_set(request.dataset);
  };
  std::string why;
  SceneConfig scene;
  if (asked.automatic()) {
    const RigMotion motion = opened.emplace(open()).motion();
    why = in_words(motion);
    scene = asked.chosen_by(motion);
    if (surface_needs_camera(*scene.settings, request.mesh)) request.mesh.clear();  // it makes its own
    std::fprintf(stderr, "the model is chosen: %s, because %s\n", scene.kind->name(), why.c_str());
  } else {
    scene = asked.named();
  }
  ModelSettings& settings = *scene.settings;
  if (request.hold_out) settings.hold_out_every = *request.hold_out;
  request.favour.fill(request.limits, request.size, settings);
  Limits limits = request.limits.apply(settings);
  limits.favour = request.favour.word;
  limits.shown = false;  // before it is finished
  const std::optional<double> tolerance = request.limits.between_lights(settings);
  const std::optional<CompressionTarget> size = request.size.target(*scene.kind, settings);
  if (request.out.empty())
    std::fprintf(stderr, "no --out: the model is built and judged, but not kept\n");
  else
    check_model_path(request.out, size.has_value());
  CaptureSet captures = opened ? *std::move(opened) : open();
  if (!request.refine.empty() && surface_needs_camera(settings, request.mesh))
    throw ConfigError(std::string("--refine: ") + settings.kind() + " has no mesh to refine; leave it out");
  if (!request.from_mesh.empty() && settings.makes_mesh())
    throw ConfigError(std::string("--from-mesh: ") + settings.kind() + " looks for no shape; leave it out");
  const bool from_images = request.mesh.empty() && !settings.makes_mesh() && !is_light_list(request.dataset);
  Mesh mesh = from_images ? found_shape(request, captures, settings.hold_out_every, fit)
                          : surface_for(settings, request.mesh, captures.cameras);
  if (const auto metres = request.object_size.metres(); metres && from_images)
    bring_to_size(*metres, request.dataset, mesh, captures, fit["shape"]);
  captures = in_frame_at(mesh.origin, std::move(captures));
  // Where the light moves images differ for that reason alone.
  if (refining == Refining::kWhereItGains && settings.makes_mesh()) refining = Refining::kNever;
  const ChosenMesh chosen =
      surface_needs_camera(settings, request.mesh)
          ? ChosenMesh{.mesh = std::move(mesh), .given = {}, .captures = std::move(captures), .doubt = {}}
          : choose_mesh(std::move(mesh), from_images ? "the shape" : request.mesh, request.dataset, std::move(captures),
                        settings.hold_out_every, refining, fit);
  const std::unique_ptr<Reconstruction> built =
      limits.psnr_db ? build_to_target(request, chosen, settings, limits)
                     : build_once(request, chosen, settings, limits, scene.measured, 0, true);
  Reconstruction& reconstruction = *built;
  const Reconstruction::Judgement judged = reconstruction.judge();
  nlohmann::json lights;
  if (tolerance) lights = light_report(*reconstruction.snapshot(), *tolerance);
  const std::string failed = worthless(judged);
  const bool saved = !request.out.empty() && failed.empty();
  std::optional<SmallFile> small;
  if (saved)
    small = save_reconstruction(reconstruction, reconstruction.give_snapshot(), request.out, request.dataset, size,
                                saving());
  if (saved && !small) note_judgement(judged.model, request.out);
  nlohmann::json report = reconstruction_report(reconstruction, judged);
  if (chosen.captures.files) report["files"] = files_report(*chosen.captures.files);
  if (asked.automatic()) report["model_choice"] = {{"model", scene.kind->name()}, {"why", why}};
  if (small) report["file"] = file_report(request.out, *small);
  report.update(fit);
  report["held_out"]["object_pixels"] = chosen.given ? "of the mesh that was given" : "of the mesh";
  if (tolerance) report["lights"] = std::move(lights);
  const std::string doubtful = mostly_unused(reconstruction.account().counts());
  if (!failed.empty() || !doubtful.empty()) report["failed"] = failed.empty() ? doubtful : failed;
  done(report);
  if (!failed.empty()) throw Error(request.dataset + ": " + failed + "; no model was written" + cause(chosen));
  if (!doubtful.empty())
    throw Error(request.dataset + ": " + doubtful +
                (saved ? "; the model of the others was written to " + request.out : "") + cause(chosen));
}

void add_build_command(Command& program) {
  auto arguments = std::make_shared<BuildRequest>();
  auto report = std::make_shared<std::string>();
  Command command = program.subcommand("build", "Builds a model from photographs or a session.");
  command
      .option("dataset", arguments->dataset,
              "folder with transforms.json, a COLMAP model or a Sheen session, a list of lights (.lp), or a folder of "
              "photographs, whose poses COLMAP then finds")
      .required();
  const Option mesh = command.option(
      "--mesh", arguments->mesh,
      "PLY, OBJ or OFF in the dataset's frame; without one the shape is found in the images, as `shape` does");
  add_rough_mesh_option(command, arguments->from_mesh).excludes({mesh});
  const Option no_refine = command.flag("--no-refine", arguments->no_refine, "build on the mesh as it is given");
  command
      .option("--refine[=mesh]", arguments->refine,
              "first correct the mesh, or with `poses` the poses too, against the images, as `refine` does; without it "
              "the mesh of a data set is corrected where images and mesh disagree and it gains")
      .excludes({no_refine});
  arguments->object_size.add_to(command);
  command.option("--out", arguments->out, "model to write: one small file, or a folder with --loss 0dB");
  command
      .option("--hold-out", arguments->hold_out,
              "hold out every Nth image where the dataset names no test views; 0 = none")
      .check(whole_number_in(0, 1'000'000));
  const Option config = command.option("--config", arguments->config, "scene file (TOML)");
  command
      .option("--model", arguments->model,
              "kind of model, without a scene file: " + names_of_kinds() +
                  "; or auto: by what moves between the images, camera or light or both")
      .excludes({config});
  arguments->favour.add_to(command);
  arguments->limits.add_to(
      command, "PSNR that held-out views must reach, such as 35dB; the cheapest setting that reaches it is searched");
  arguments->size.add_to(command);
  command.option("--json", *report, "report to write; - for standard output");
  command.callback([arguments, report] {
    install_stop_signals();
    const EndOnStop give_up("sheen-reconstructor: stopped before it was done");
    ReportFile json(*report);
    build(*arguments, [&](const nlohmann::json& made) {
      print_summary(made);
      json.write(to_text(made));
    });
  });
}

}  // namespace sheen
