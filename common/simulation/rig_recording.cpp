// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/rig_recording.h"

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/base/json_fields.h"

namespace sheen {
namespace {

using nlohmann::json;
constexpr char kFormat[] = "sheen-rig";
constexpr int kVersion = 1;
constexpr double kHuge = 1e6;

json pose_json(const Rigid3& pose) {
  const auto& q = pose.rotation;
  const auto& t = pose.translation;
  return {{"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}}, {"translation_m", {t.x(), t.y(), t.z()}}};
}

Rigid3 read_pose(const JsonFields& fields, const json& value, const std::string& where) {
  const json& q = fields.array(fields.member(value, "rotation_xyzw", where), where + "rotation_xyzw", 4, 4);
  const json& t = fields.array(fields.member(value, "translation_m", where), where + "translation_m", 3, 3);
  Rigid3 pose;
  for (int i = 0; i < 4; ++i) pose.rotation.coeffs()[i] = fields.number(q[i], where + "rotation_xyzw", -1, 1);
  if (std::abs(pose.rotation.norm() - 1) > 1e-6) fields.fail(where + "rotation_xyzw", "must be a unit quaternion");
  for (int i = 0; i < 3; ++i) pose.translation[i] = fields.number(t[i], where + "translation_m", -kHuge, kHuge);
  return pose;
}

Camera read_camera(const JsonFields& fields, const json& value) {
  const auto number = [&](const char* key) {
    return fields.number(fields.member(value, key, "camera."), std::string("camera.") + key, -kHuge, kHuge);
  };
  Camera camera;
  camera.width = static_cast<int>(fields.integer(fields.member(value, "width", "camera."), "camera.width", 1, 1 << 16));
  camera.height =
      static_cast<int>(fields.integer(fields.member(value, "height", "camera."), "camera.height", 1, 1 << 16));
  camera.fx = number("fx");
  camera.fy = number("fy");
  camera.cx = number("cx");
  camera.cy = number("cy");
  const json& k = fields.array(fields.member(value, "distortion", "camera."), "camera.distortion", 5, 5);
  for (int i = 0; i < 5; ++i) camera.distortion[i] = fields.number(k[i], "camera.distortion", -kHuge, kHuge);
  if (const std::string error = validation_error(camera); !error.empty()) fields.fail("camera", "is wrong: " + error);
  return camera;
}

}  // namespace

RigRecording load_rig_recording(const std::filesystem::path& folder) {
  const JsonFields fields(folder / "rig.json");
  const json file = fields.open(kFormat, kVersion, "render one with `sheen-tracker simulate --out DIR`");
  RigRecording recording{.folder = folder};
  recording.parameters_hash = fields.text(fields.member(file, "parameters_hash", ""), "parameters_hash");
  recording.camera = read_camera(fields, fields.member(file, "camera", ""));
  recording.format = pixel_format_from_pfnc(fields.text(fields.member(file, "pixel_format", ""), "pixel_format"));
  if (recording.format == PixelFormat::kUnspecified) fields.fail("pixel_format", "is not a format of this program");
  recording.frame_rate_hz = fields.number(fields.member(file, "frame_rate_hz", ""), "frame_rate_hz", 0.001, 10000);
  const json& exposure = fields.member(file, "exposure", "");
  recording.exposure.exposure_s =
      fields.number(fields.member(exposure, "exposure_s", "exposure."), "exposure.exposure_s", 0, 1000);
  recording.exposure.gain_db =
      fields.number(fields.member(exposure, "gain_db", "exposure."), "exposure.gain_db", 0, 100);
  recording.exposure.locked = true;
  const json& frames = fields.array(fields.member(file, "frames", ""), "frames", 1, 1 << 20);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string where = "frames[" + std::to_string(i) + "].";
    RigFrame frame;
    frame.raw_file = folder / fields.text(fields.member(frames[i], "raw_file", where), where + "raw_file");
    frame.camera_from_object =
        read_pose(fields, fields.member(frames[i], "camera_from_object", where), where + "camera_from_object.");
    frame.blur_px = fields.number(fields.member(frames[i], "blur_px", where), where + "blur_px", 0, kHuge);
    recording.frames.push_back(std::move(frame));
  }
  return recording;
}

void save_rig_recording(const RigRecording& recording) {
  const Camera& c = recording.camera;
  json frames = json::array();
  for (const RigFrame& frame : recording.frames)
    frames.push_back({{"raw_file", frame.raw_file.lexically_relative(recording.folder).generic_string()},
                      {"camera_from_object", pose_json(frame.camera_from_object)},
                      {"blur_px", frame.blur_px}});
  const json file = {
      {"format", kFormat},
      {"version", kVersion},
      {"parameters_hash", recording.parameters_hash},
      {"camera",
       {{"width", c.width},
        {"height", c.height},
        {"fx", c.fx},
        {"fy", c.fy},
        {"cx", c.cx},
        {"cy", c.cy},
        {"distortion", c.distortion}}},
      {"pixel_format", std::string(pfnc_name(recording.format))},
      {"frame_rate_hz", recording.frame_rate_hz},
      {"exposure", {{"exposure_s", recording.exposure.exposure_s}, {"gain_db", recording.exposure.gain_db}}},
      {"frames", frames}};
  write_file(recording.folder / "rig.json", file.dump(1) + "\n");
}

}  // namespace sheen
