// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/saved_model.h"

#include <malloc.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/models/model_registry.h"
#include "reconstructor/scene/scene_config.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kSceneKey = "scene";              // the settings as a scene file
constexpr const char* kCapturesKey = "captures";        // a JSON list: source_session, sequence, part, exposure_gain
constexpr const char* kPoseKey = "camera_from_object";  // of these, where it is not the source's
constexpr const char* kCalibrationKey = "error_calibration";  // JSON: views, offset_db, half_width_db
constexpr const char* kHeldOutPsnrKey = "held_out_psnr_db";
const std::set<std::string> kModelFiles{kModelJsonFile, "mesh.ply", "maps.exr", "field.rif", "views.ilg"};
constexpr const char *kHeldOut = "held_out", *kFolded = "folded", *kRepeated = "repeated";

json read_description(const fs::path& model_folder) {
  const fs::path file = model_folder / kModelJsonFile;
  try {
    return json::parse(read_file(file));
  } catch (const json::exception& error) {
    throw FileError(file.string(), std::string("is not valid JSON: ") + error.what());
  }
}

/// The file of a model that says what was noted of it: itself, or the one in its folder.
fs::path notes_file(const fs::path& model) {
  return fs::is_directory(model) ? model / kModelJsonFile : model;
}

/// Of a model that is one file. Throws FileError.
const ModelKind& kind_of_file(const fs::path& file) {
  constexpr std::size_t kStart = 64;
  const std::string start = read_file_start(file, kStart);
  for (const ModelKind* kind : model_kinds())
    if (kind->reads_file(start)) return *kind;
  throw FileError(file.string(), "is not a model that this program knows");
}

ModelMetadata metadata_in(const json& description, const fs::path& file) {
  ModelMetadata notes;
  const auto metadata = description.find("metadata");
  if (metadata == description.end()) return notes;
  if (!metadata->is_object()) throw FileError(file.string(), "metadata: must be an object");
  for (const auto& [key, value] : metadata->items()) {
    if (!value.is_string()) throw FileError(file.string(), "metadata." + key + ": must be a text");
    notes[key] = value.get<std::string>();
  }
  return notes;
}

/// Quaternion (w, x, y, z), then translation.
std::array<double, 7> numbers_of(const Rigid3& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  return {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
}

Rigid3 pose_of(const std::array<double, 7>& numbers, const fs::path& file) {
  const Eigen::Quaterniond rotation(numbers[0], numbers[1], numbers[2], numbers[3]);
  const Eigen::Vector3d translation(numbers[4], numbers[5], numbers[6]);
  if (!translation.allFinite() || !(std::abs(rotation.norm() - 1) < 1e-3))
    throw FileError(file.string(), std::string("metadata.captures: ") + kPoseKey + " is no pose");
  return {rotation.normalized(), translation};
}

/// What is noted of how a model came to be.
ModelMetadata metadata_of(const Reconstruction& reconstruction, const std::string& source) {
  json captures = json::array();
  for (const KnownCapture& c : reconstruction.account().captures()) {
    if (c.status == IngestStatus::kRefused) continue;
    captures.push_back({{"source_session", c.source_session},
                        {"sequence", c.sequence},
                        {"part", c.status == IngestStatus::kHeldOut ? kHeldOut : (c.repeated ? kRepeated : kFolded)},
                        {"exposure_gain", c.exposure_gain}});
    if (c.camera_from_object) captures.back()[kPoseKey] = numbers_of(*c.camera_from_object);
  }
  return {{"source", source},
          {"images", std::to_string(reconstruction.account().counts().accepted)},
          {kSceneKey, to_toml(reconstruction.model().settings())},
          {kCapturesKey, captures.dump(-1, ' ', false, json::error_handler_t::replace)}};
}

/// Whether a file is where a folder is to be, or the other way round.
bool is_in_the_way(const fs::path& path, bool one_file) {
  return fs::exists(path) && fs::is_directory(path) == one_file;
}

/// Saves where an older model of the other form may be, which stays until the new one is whole.
void save_at(const fs::path& path, bool one_file, const ModelSnapshot& model, const ModelMetadata& metadata,
             const StepsDone& progress) {
  if (!is_in_the_way(path, one_file)) return model.save(path, metadata, progress);
  const fs::path fresh = path.string() + ".new", older = path.string() + ".older";
  fs::remove_all(fresh);  // of a save that was killed
  fs::remove_all(older);
  model.save(fresh, metadata, progress);
  fs::rename(path, older);
  fs::rename(fresh, path);
  fs::remove_all(older);
}

}  // namespace

void check_model_path(const fs::path& path, bool one_file) {
  if (!is_in_the_way(path, one_file)) return one_file ? check_writable(path) : check_writable_folder(path);
  check_writable(path.string() + ".new");
  if (!one_file) {
    kind_of_file(path);
    return;
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(path))
    if (const std::string name = entry.path().filename(); !kModelFiles.contains(name))
      throw FileError(path.string(),
                      "is a folder with other things than a model (" + name + "); name a file to write the model to");
}

std::optional<SmallFile> save_reconstruction(const Reconstruction& reconstruction,
                                             std::shared_ptr<const ModelSnapshot> model, const fs::path& path,
                                             const std::string& source, std::optional<CompressionTarget> size,
                                             const StepsDone& progress) {
  model = model->filled();
  const ModelMetadata metadata = metadata_of(reconstruction, source);
  if (!size) {
    save_at(path, false, *model, metadata, progress);
    return std::nullopt;
  }
  const std::vector<HeldOutView>& views = reconstruction.held_out();
  size->progress = progress;
  if (!views.empty())
    size->judge = [&views](const ModelSnapshot& small) {
      const RayPainter painter(small.mesh());
      double sum = 0;
      for (const HeldOutView& view : views) sum += score_object(view, small, painter).psnr_db;
      return sum / static_cast<double>(views.size());
    };
  malloc_trim(0);  // what images and judging took
  const std::unique_ptr<Compression> compression = model->compression(*size);
  model.reset();
  malloc_trim(0);  // what it took lies scattered between what was made of it
  const CompressedModel small = compression->run();
  save_at(path, true, *small.snapshot, metadata, {});
  note_judgement(score(views, *small.snapshot, RayPainter(small.snapshot->mesh())), path);
  return SmallFile{fs::file_size(path), small.loss_db, size->bytes || small.loss_db <= size->loss_db};
}

void note_judgement(const Scores& scores, const fs::path& model) {
  ModelMetadata notes;
  if (std::isfinite(scores.psnr_db)) notes[kHeldOutPsnrKey] = std::to_string(scores.psnr_db);
  if (const ErrorCalibration calibration = calibrate(scores); calibration.known())
    notes[kCalibrationKey] = json{{"views", calibration.views},
                                  {"offset_db", calibration.offset_db},
                                  {"half_width_db", calibration.half_width_db}}
                                 .dump();
  if (notes.empty()) return;
  if (fs::is_directory(model)) {
    json description = read_description(model);
    for (const auto& [key, note] : notes) description["metadata"][key] = note;
    write_file(notes_file(model), description.dump() + "\n");
  } else {
    const ModelKind& kind = kind_of_file(model);
    notes.merge(kind.file_metadata(model));
    kind.set_file_metadata(model, notes);
  }
}

std::uintmax_t saved_bytes(const fs::path& path) {
  if (!fs::is_directory(path)) return fs::file_size(path);
  std::uintmax_t bytes = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(path))
    if (kModelFiles.contains(entry.path().filename())) bytes += entry.file_size();
  return bytes;
}

double held_out_psnr_db(const SavedModel& model) {
  const auto noted = model.metadata.find(kHeldOutPsnrKey);
  if (noted == model.metadata.end()) return std::numeric_limits<double>::quiet_NaN();
  return std::strtod(noted->second.c_str(), nullptr);
}

ErrorCalibration calibration_of(const SavedModel& model, const fs::path& path) {
  const auto noted = model.metadata.find(kCalibrationKey);
  if (noted == model.metadata.end()) return {};
  try {
    const json calibration = json::parse(noted->second);
    return {.views = calibration.at("views"),
            .offset_db = calibration.at("offset_db"),
            .half_width_db = calibration.at("half_width_db")};
  } catch (const json::exception& error) {
    throw FileError(notes_file(path).string(), std::string("metadata.") + kCalibrationKey + ": " + error.what());
  }
}

const KnownCapture* ModelOrigin::find(const Capture& capture) const {
  const auto found = captures.find({capture.source_session, capture.sequence});
  return found == captures.end() ? nullptr : &found->second;
}

const ModelKind& kind_of_model(const fs::path& path) {
  if (!fs::exists(path)) throw FileError(path.string(), "no such model");
  if (!fs::is_directory(path)) return kind_of_file(path);
  const json description = read_description(path);
  const auto format = description.is_object() ? description.find("format") : description.end();
  for (const ModelKind* kind : model_kinds())
    if (format != description.end() && *format == kind->file_format()) return *kind;
  throw FileError(notes_file(path).string(), "describes no model that this program knows");
}

SavedModel open_model(const fs::path& path) {
  const ModelKind& kind = kind_of_model(path);
  if (!fs::is_directory(path)) return {&kind, kind.load(path), kind.file_metadata(path)};
  return {&kind, kind.load(path), metadata_in(read_description(path), notes_file(path))};
}

ModelOrigin origin_of(const SavedModel& model, const fs::path& path) {
  const ModelMetadata& metadata = model.metadata;
  if (!metadata.contains(kSceneKey) || !metadata.contains(kCapturesKey))
    throw FileError(path.string(),
                    "was saved by an older Sheen and does not say which images it was built from; build it again");
  const fs::path file = notes_file(path);
  ModelOrigin origin;
  try {
    origin.settings = parse_scene_config(metadata.at(kSceneKey), file).settings;
  } catch (const ConfigError& error) {
    throw FileError(path.string(),
                    std::string("was saved by another version of Sheen; build it again: ") + error.what());
  }
  try {
    for (const json& entry : json::parse(metadata.at(kCapturesKey))) {
      const auto part = entry.at("part").get<std::string>();
      KnownCapture known{.source_session = entry.at("source_session"),
                         .sequence = entry.at("sequence"),
                         .status = part == kHeldOut ? IngestStatus::kHeldOut : IngestStatus::kAccepted,
                         .repeated = part == kRepeated,
                         .exposure_gain = entry.at("exposure_gain")};
      if (!(known.exposure_gain > 0))
        throw FileError(file.string(), "metadata.captures: exposure_gain must be positive");
      if (const auto pose = entry.find(kPoseKey); pose != entry.end())
        known.camera_from_object = pose_of(pose->get<std::array<double, 7>>(), file);
      origin.captures.insert_or_assign({known.source_session, known.sequence}, std::move(known));
    }
  } catch (const json::exception& error) {
    throw FileError(file.string(), std::string("metadata.captures: ") + error.what());
  }
  return origin;
}

}  // namespace sheen
