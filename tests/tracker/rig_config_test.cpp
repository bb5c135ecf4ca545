// SPDX-License-Identifier: Apache-2.0
#include "tracker/rig_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/base/errors.h"
#include "common/camera/camera_file.h"
#include "tests/support/camera_responses.h"

namespace sheen {
namespace {

using ::testing::HasSubstr;

const std::string kCamera = "[camera]\nwidth = 1024\nheight = 768\nfx = 1200.5\nfy = 1200\ncx = 511.5\ncy = 383\n";

class RigConfigFile : public ::testing::Test {
 protected:
  RigConfigFile() { std::filesystem::create_directories(folder); }
  ~RigConfigFile() override { std::filesystem::remove_all(folder); }
  RigConfig load(const std::string& text) const {
    std::ofstream(folder / "rig.toml") << text;
    return load_rig_config(folder / "rig.toml");
  }
  std::string error(const std::string& text) const {
    try {
      load(text);
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "no error";
  }
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() /
      ("sheen_rig_config_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

TEST_F(RigConfigFile, ReadsEverySection) {
  const RigConfig config = load(kCamera +
                                "lens = \"fisheye\"\ndistortion = [0.1, -0.2, 0, 0.01]\n"
                                "[stage]\nfile = \"stage.json\"\n"
                                "[source]\nuri = \"aravis:127.0.0.1\"\nframe_rate_hz = 30\nexposure_us = 5000.0\n"
                                "[link]\nendpoint = \"tcp://10.0.0.1:7410\"\nkeys = \"t.key\"\nallow = \"allow\"\n"
                                "[gate]\nmin_tags = 8\nmax_blur_px = 1.5\n");
  ASSERT_TRUE(config.cameras[0].camera);
  EXPECT_EQ(config.cameras[0].camera->fx, 1200.5);
  EXPECT_EQ(config.cameras[0].camera->lens, LensModel::kFisheye);
  EXPECT_EQ(config.cameras[0].camera->distortion, (std::array<double, 5>{0.1, -0.2, 0, 0.01, 0}));
  EXPECT_EQ(config.stage_file, folder / "stage.json");
  EXPECT_EQ(config.cameras[0].source_uri, "aravis:127.0.0.1");
  EXPECT_EQ(config.cameras[0].source.width, 1024);
  EXPECT_EQ(config.cameras[0].source.frame_rate_hz, 30);
  EXPECT_EQ(config.endpoint, "tcp://10.0.0.1:7410");
  EXPECT_EQ(config.keys, folder / "t.key");
  EXPECT_EQ(config.cameras[0].gate.min_tags, 8);
  EXPECT_EQ(config.cameras[0].gate.max_blur_px, 1.5);
  EXPECT_EQ(config.cameras[0].gate.min_angle_deg, GateOptions{}.min_angle_deg);
}

TEST_F(RigConfigFile, TheExamplesAreRead) {
  for (const char* file : {"camera.json", "left.json", "middle.json", "right.json"})
    save_camera({.camera = *load(kCamera).cameras[0].camera}, folder / file);
  int examples = 0;
  for (const auto& example : std::filesystem::directory_iterator(SHEEN_EXAMPLES)) {
    if (!example.path().filename().string().ends_with("rig.toml")) continue;
    ++examples;
    const auto copy = folder / example.path().filename();
    std::filesystem::copy_file(example.path(), copy, std::filesystem::copy_options::overwrite_existing);
    const RigConfig config = load_rig_config(copy);
    EXPECT_TRUE(config.cameras[0].camera) << copy;
    EXPECT_TRUE(config.stage_file) << copy;
    EXPECT_EQ(config.cameras.size(), copy.filename() == "three_cameras_rig.toml" ? 3u : 1u) << copy;
    const bool lamp_moves = copy.filename() == "gantry_rig.toml" || copy.filename() == "tagged_lamp_rig.toml";
    EXPECT_EQ(config.cameras[0].light.has_value(), lamp_moves) << copy;
    EXPECT_EQ(config.cameras[0].light && config.cameras[0].light->tag, copy.filename() == "tagged_lamp_rig.toml")
        << copy;
  }
  EXPECT_EQ(examples, 4);
}

TEST_F(RigConfigFile, SaysWhereTheLightComesFrom) {
  EXPECT_FALSE(load(kCamera).cameras[0].light);
  EXPECT_FALSE(load(kCamera).cameras[0].still);
  const RigConfig gantry = load(kCamera + "still = true\n[light]\ntable = \"lamps.lp\"\nindex = \"index.csv\"\n");
  EXPECT_TRUE(gantry.cameras[0].still);
  EXPECT_EQ(gantry.cameras[0].light->table, folder / "lamps.lp");
  EXPECT_EQ(gantry.cameras[0].light->index, folder / "index.csv");
  EXPECT_EQ(load("[light]\ntable = \"lamps.lp\"\nfirst_frame = 1\n").cameras[0].light->first_frame, 1u);
  const RigConfig lamp = load("[light]\ntag = 40\ntag_size_m = 0.05\noffset = [0, -0.1, 0.02]\n");
  EXPECT_EQ(lamp.cameras[0].light->tag, 40);
  EXPECT_EQ(lamp.cameras[0].light->offset, Eigen::Vector3d(0, -0.1, 0.02));
  EXPECT_THAT(error("[light]\n"), HasSubstr("rig.toml:1: light.table or tag"));
  EXPECT_THAT(error("[light]\ntable = \"a.lp\"\n"), HasSubstr("light.table needs index"));
  EXPECT_THAT(error("[light]\ntag = 4\n"), HasSubstr("light.tag_size_m must lie in"));
  EXPECT_THAT(error("[light]\ntag = 4\noffset = [1, 2]\n"), HasSubstr("rig.toml:3: light.offset must be a list of 3"));
  EXPECT_THAT(error("[light]\nlamp = 4\n"), HasSubstr("light.lamp is unknown; [light] has first_frame, index"));
  EXPECT_THAT(error(kCamera + "still = 1\n"), HasSubstr("camera.still must be true or false"));
}

TEST_F(RigConfigFile, TakesTheCameraThatCalibrateWrote) {
  const Camera camera{.width = 640, .height = 480, .fx = 530, .fy = 531, .cx = 320, .cy = 241, .distortion = {-0.2}};
  save_camera({camera, 0.001}, folder / "camera.json");
  const RigConfig config = load("[camera]\nfile = \"camera.json\"\n");
  EXPECT_EQ(*config.cameras[0].camera, camera);
  EXPECT_EQ(config.cameras[0].source.width, 640);
  EXPECT_FALSE(config.cameras[0].photometry);
  PhotometricCalibration light{.response = "srgb"};
  light.vignette = PhotometricCalibration::VignetteUncertainty{};
  light.white_balance.emplace();
  light.photometry = {srgb_response(0.01), {320, 240, {-0.2, 0, 0}}, {1.5f, 1, 1.25f}, 1};
  save_camera({camera, 0.001, light}, folder / "camera.json");
  EXPECT_EQ(load("[camera]\nfile = \"camera.json\"\n").cameras[0].photometry, light.photometry);
  EXPECT_THAT(error("[camera]\nfile = \"camera.json\"\nfx = 3\n"), HasSubstr("rig.toml:1: camera.file stands beside"));
  EXPECT_THROW(load("[camera]\nfile = \"none.json\"\n"), FileError);
}

TEST_F(RigConfigFile, SaysHowTheCameraIsToBeSet) {
  const RigConfig config =
      load("[source]\nblack_level = 12.5\nwhite_balance = [1.5, 1, 2]\npixel_format = \"BayerRG8\"\n");
  EXPECT_EQ(config.cameras[0].source.black_level, 12.5);
  EXPECT_EQ(config.cameras[0].source.white_balance, (std::array<double, 3>{1.5, 1, 2}));
  EXPECT_EQ(config.cameras[0].source.pixel_format, "BayerRG8");
  EXPECT_THAT(error("[source]\nwhite_balance = [1, 2]\n"), HasSubstr("source.white_balance must be a list of 3"));
  EXPECT_THAT(error("[source]\nwhite_balance = [1, 0, 2]\n"), HasSubstr("above 0"));
  EXPECT_THAT(error("[source]\npixel_format = \"Bayer\"\n"), HasSubstr("source.pixel_format must be BayerRG8"));
}

TEST_F(RigConfigFile, NamesKeyAndLineOfWhatIsWrong) {
  EXPECT_THAT(error("[gate]\nmin_tags = 6\nmin_tag = 7\n"), HasSubstr("rig.toml:3: gate.min_tag is unknown"));
  EXPECT_THAT(error("\n[camra]\nfx = 1\n"), HasSubstr("rig.toml:2: unknown section [camra]"));
  EXPECT_THAT(error("[camera]\nwidth = 1024\n"), HasSubstr("camera.height is missing"));
  EXPECT_THAT(error("[gate]\nmax_blur_px = \"two\"\n"), HasSubstr("rig.toml:2: gate.max_blur_px must be a number"));
  EXPECT_THAT(error("[gate]\nmax_blur_px = -2\n"), HasSubstr("gate.max_blur_px must lie in 0.01..1000"));
  EXPECT_THAT(error("[gate]\nmin_tags = 6.5\n"), HasSubstr("whole number"));
  EXPECT_THAT(error("[camera]\nfx = inf\n"), HasSubstr("camera.fx must be a number"));
  EXPECT_THAT(error("[camera]\nwidth = 8\nheight = 8\nfx = 1e-300\nfy = 8\ncx = 4\ncy = 4\n"),
              HasSubstr("rig.toml:1: camera.fx must be 0.001 to"));
  for (const char* key :
       {"max_blur_px", "max_uncertainty_px", "max_overexposed", "min_bright", "min_angle_deg", "min_distance_m"})
    for (const char* value : {"-1", "1e300", "nan", "inf"})
      EXPECT_THAT(error(std::string("[gate]\n") + key + " = " + value + "\n"), HasSubstr(std::string("gate.") + key));
  for (const char* value : {"0", "1", "588", "-3", "2147483648"})
    EXPECT_THAT(error(std::string("[gate]\nmin_tags = ") + value + "\n"), HasSubstr("gate.min_tags"));
  for (const char* key : {"frame_rate_hz", "exposure_us"})
    for (const char* value : {"-1", "1e-300", "1e300", "nan", "inf"})
      EXPECT_THAT(error(std::string("[source]\n") + key + " = " + value + "\n"),
                  HasSubstr(std::string("source.") + key));
  for (const char* value : {"101", "1e300", "nan"})
    EXPECT_THAT(error(std::string("[source]\ngain_db = ") + value + "\n"), HasSubstr("source.gain_db"));
  EXPECT_THAT(error(kCamera + "lens = \"pinhole\"\n"), HasSubstr("camera.lens must be"));
  EXPECT_THAT(error(kCamera + "distortion = [1, 2, 3, 4, 5, 6]\n"), HasSubstr("camera.distortion must be"));
  EXPECT_THAT(error("gate = 3\n"), HasSubstr("unknown section"));
  EXPECT_THAT(error("[gate\n"), HasSubstr("rig.toml:1"));
  EXPECT_THROW(load_rig_config(folder / "absent.toml"), FileError);
  EXPECT_THROW(load_rig_config(folder), FileError);
}

const std::string kLeft =
    "[[cameras]]\nname = \"left\"\nsource.uri = \"aravis:1\"\ncamera.width = 640\ncamera.height = 480\n"
    "camera.fx = 500\ncamera.fy = 500\ncamera.cx = 320\ncamera.cy = 240\n";

TEST_F(RigConfigFile, HasSeveralCameras) {
  save_camera({.camera = *load(kCamera).cameras[0].camera}, folder / "right.json");
  const RigConfig config = load(
      "[stage]\nfile = \"stage.json\"\n[source]\nexposure_us = 2000\ngain_db = 3\n[gate]\nmin_tags = 8\n"
      "[light]\ntable = \"lamps.lp\"\nindex = \"index.csv\"\n" +
      kLeft +
      "gate.max_blur_px = 1\n[[cameras]]\nname = \"right\"\nsource.uri = \"aravis:2\"\nsource.gain_db = 6\n"
      "light.index = \"right.csv\"\n[cameras.camera]\nfile = \"right.json\"\nstill = true\n");
  ASSERT_EQ(config.cameras.size(), 2u);
  const CameraConfig &left = config.cameras[0], &right = config.cameras[1];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(left.camera->width, 640);
  EXPECT_EQ(left.source.width, 640);
  EXPECT_EQ(left.source_uri, "aravis:1");
  EXPECT_EQ(left.source.exposure_us, 2000);
  EXPECT_EQ(left.source.gain_db, 3);
  EXPECT_EQ(left.gate.min_tags, 8);
  EXPECT_EQ(left.gate.max_blur_px, 1);
  EXPECT_FALSE(left.still);
  EXPECT_EQ(left.light->index, folder / "index.csv");
  EXPECT_EQ(right.name, "right");
  EXPECT_EQ(right.camera->fx, 1200.5);
  EXPECT_EQ(right.source.exposure_us, 2000);
  EXPECT_EQ(right.source.gain_db, 6);
  EXPECT_EQ(right.gate.min_tags, 8);
  EXPECT_EQ(right.gate.max_blur_px, GateOptions{}.max_blur_px);
  EXPECT_TRUE(right.still);
  EXPECT_EQ(right.light->index, folder / "right.csv");
  EXPECT_EQ(right.light->table, folder / "lamps.lp");
}

TEST_F(RigConfigFile, NamesWhatIsWrongWithSeveralCameras) {
  EXPECT_THAT(error(kCamera + kLeft), HasSubstr("[[cameras]] stands beside [camera]"));
  EXPECT_THAT(error("[source]\nuri = \"aravis:1\"\n" + kLeft), HasSubstr("[[cameras]] stands beside"));
  EXPECT_THAT(error(kLeft + kLeft), HasSubstr("rig.toml:10: two cameras have the name left"));
  EXPECT_THAT(error(kLeft + "[[cameras]]\nname = \"right\"\n"), HasSubstr("camera right: camera.file is missing"));
  std::string same_source = kLeft;
  same_source.replace(same_source.find("left"), 4, "twin");
  EXPECT_THAT(error(kLeft + same_source), HasSubstr("left and twin have the same source.uri, aravis:1"));
  std::string no_source = kLeft;
  no_source.erase(no_source.find("source.uri"), std::string("source.uri = \"aravis:1\"\n").size());
  EXPECT_THAT(error(no_source), HasSubstr("rig.toml:1: camera left: source.uri is missing"));
  EXPECT_THAT(error(kLeft + "camera.focal = 3\n"), HasSubstr("rig.toml:10: camera.focal is unknown"));
  EXPECT_THAT(error(kLeft + "stage.file = \"a\"\n"), HasSubstr("an entry of [[cameras]] has name, and [camera]"));
  EXPECT_THAT(error(kLeft + "gate.max_blur_px = -1\n"), HasSubstr("camera left: gate.max_blur_px"));
  EXPECT_THAT(error(kLeft + "source.exposure_us = -1\n"), HasSubstr("camera left: source.exposure_us"));
  EXPECT_THAT(error("cameras = []\n"), HasSubstr("cameras must be [[cameras]]"));
  EXPECT_THAT(error("cameras = [1, 2]\n"), HasSubstr("cameras must be [[cameras]]"));
  EXPECT_THAT(error("[cameras]\nname = \"left\"\n"), HasSubstr("cameras must be [[cameras]]"));
  for (const char* name : {"", "\"\"", "\"a b\"", "\"../x\"", "3", "\"a-name-of-more-than-thirty-two-characters\""})
    EXPECT_THAT(error("[[cameras]]\n" + (*name ? std::string("name = ") + name : "") + "\n"), HasSubstr("needs a name"))
        << name;
}

TEST_F(RigConfigFile, FindsACameraByItsName) {
  const auto refusal = [](RigConfig config, const std::string& name) {
    try {
      return camera_named(config, name).name;
    } catch (const ConfigError& e) {
      return std::string(e.what());
    }
  };
  std::string right = kLeft;
  right.replace(right.find("left"), 4, "rite").replace(right.find("aravis:1"), 8, "aravis:2");
  EXPECT_EQ(refusal(load(kLeft + right), "rite"), "rite");
  EXPECT_EQ(refusal(load(kCamera), ""), "");
  EXPECT_THAT(refusal(load(kLeft + right), ""), HasSubstr("several cameras: left, rite; say which one with --camera"));
  EXPECT_THAT(refusal(load(kLeft + right), "top"), HasSubstr("no camera named top; it has left, rite"));
  EXPECT_THAT(refusal(load(kCamera), "top"), HasSubstr("its only camera has no name"));
}

TEST(SourceUri, NamesTheThreeKinds) {
  EXPECT_EQ(parse_source_uri("aravis:Vendor-1:2").target, "Vendor-1:2");
  EXPECT_EQ(parse_source_uri("video:/dev/video0").kind, SourceKind::kVideo);
  EXPECT_EQ(parse_source_uri("dataset:a/b").kind, SourceKind::kDataset);
  for (const char* wrong : {"", "aravis", "aravis:", "usb:1", "dataset:", "/tmp/x"})
    EXPECT_THROW(parse_source_uri(wrong), ConfigError) << wrong;
}

}  // namespace
}  // namespace sheen
