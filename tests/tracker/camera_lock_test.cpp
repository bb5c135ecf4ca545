// SPDX-License-Identifier: Apache-2.0
// A camera over real GigE Vision that describes itself as each test wants it, and the descriptions of real cameras.
#include <arv.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "tests/support/shared_data.h"
#include "tests/support/temp_folder.h"
#include "tracker/camera_server/camera_server.h"
#include "tracker/sources/aravis_camera.h"

namespace sheen {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr char kAddress[] = "127.0.0.1";

/// A number in the camera's memory; Aravis' fake camera has its own registers at the addresses given.
std::string number(const std::string& name, int address, const std::string& kind = "Integer") {
  char where[16];
  std::snprintf(where, sizeof where, "0x%x", address);
  return "<" + kind + " Name=\"" + name + "\"><pValue>" + name + "Reg</pValue></" + kind + "><IntReg Name=\"" + name +
         "Reg\"><Address>" + where +
         "</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort><Sign>Unsigned</Sign>"
         "<Endianess>BigEndian</Endianess></IntReg>\n";
}

std::string choice(const std::string& name, const std::string& value, const std::vector<std::string>& entries,
                   const std::vector<std::uint32_t>& values) {
  std::string xml = "<Enumeration Name=\"" + name + "\">";
  for (std::size_t i = 0; i < entries.size(); ++i)
    xml += "<EnumEntry Name=\"" + entries[i] + "\"><Value>" + std::to_string(values[i]) + "</Value></EnumEntry>";
  return xml + "<pValue>" + value + "</pValue></Enumeration>\n";
}

std::string switched(const std::string& name, int address) {
  return choice(name, name + "NumberReg", {"Off", "Continuous"}, {0, 2}) + number(name + "Number", address);
}

/// A switch that stands at "on" where its memory is 0.
std::string switched_on(const std::string& name, int address) {
  return "<Boolean Name=\"" + name + "\"><pValue>" + name +
         "NumberReg</pValue><OnValue>0</OnValue><OffValue>1</OffValue>" + "</Boolean>\n" +
         number(name + "Number", address);
}

std::string exposure_and_gain() {
  return number("ExposureTime", 0x120, "Float") + number("GainRaw", 0x110);
}

/// Memory of a camera starts as zeros, except for what the server writes.
std::string description(const std::string& more, const std::string& exposure = exposure_and_gain()) {
  return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
         "<RegisterDescription ModelName=\"Locks\" VendorName=\"Sheen\" StandardNameSpace=\"None\" "
         "SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" MajorVersion=\"1\" "
         "MinorVersion=\"0\" SubMinorVersion=\"0\" ProductGuid=\"6f9b2f0e-31cc-4a0c-8f5c-1\" "
         "VersionGuid=\"6f9b2f0e-31cc-4a0c-8f5c-2\" xmlns=\"http://www.genicam.org/GenApi/Version_1_0\">\n"
         "<Category Name=\"Root\"/>\n" +
         number("SensorWidth", 0x11c) + number("SensorHeight", 0x118) + number("Width", 0x100) +
         number("Height", 0x104) + number("OffsetX", 0x130) + number("OffsetY", 0x134) +
         choice("PixelFormat", "PixelFormatNumberReg", {"Mono8", "BayerRG8"}, {0x01080001, 0x01080009}) +
         number("PixelFormatNumber", 0x128) +
         choice("AcquisitionMode", "AcquisitionModeNumberReg", {"Continuous", "SingleFrame"}, {1, 2}) +
         number("AcquisitionModeNumber", 0x12c) +
         "<Command Name=\"AcquisitionStart\"><pValue>AcquisitionReg</pValue><CommandValue>1</CommandValue></Command>\n"
         "<Command Name=\"AcquisitionStop\"><pValue>AcquisitionReg</pValue><CommandValue>0</CommandValue></Command>\n" +
         number("Acquisition", 0x124) +
         "<IntSwissKnife Name=\"PayloadSize\"><pVariable Name=\"W\">WidthReg</pVariable>"
         "<pVariable Name=\"H\">HeightReg</pVariable><Formula>W * H</Formula></IntSwissKnife>\n" +
         exposure + more + "<Port Name=\"Device\"/>\n</RegisterDescription>\n";
}

std::string all_features() {
  return switched("ExposureAuto", 0x400) + switched("GainAuto", 0x404) + switched("BalanceWhiteAuto", 0x408) +
         number("BlackLevel", 0x40c) +
         choice("BalanceRatioSelector", "BalanceRatioSelectorNumberReg", {"Red", "Green", "Blue"}, {0, 1, 2}) +
         number("BalanceRatioSelectorNumber", 0x410) + number("BalanceRatioRaw", 0x414);
}

class CameraLock : public ::testing::Test {
 protected:
  CameraLock() {
    recording.folder = temp.path();
    recording.camera = {.width = 320, .height = 240, .fx = 300, .fy = 300, .cx = 160, .cy = 120};
    recording.frame_rate_hz = 20;
    recording.exposure.exposure_s = 0.004;
    recording.frames.push_back({.raw_file = temp.write("0.raw", std::string(320 * 240, '\x40'))});
  }
  std::unique_ptr<CameraServer> serve(const std::string& xml) {
    CameraServerOptions options{.address = kAddress, .loop = true};
    if (!xml.empty()) options.description = temp.write("camera.xml", xml);
    return std::make_unique<CameraServer>(recording, options);
  }
  std::string refusal(const SourceSettings& settings) {
    try {
      const AravisCamera camera(kAddress, settings);
      return "accepted: " + lock_failures(camera.locks());
    } catch (const DeviceError& error) {
      return error.what();
    }
  }

  TempFolder temp;
  RigRecording recording;
};

TEST_F(CameraLock, WhatIsAskedForIsSetReadBackAndListed) {
  const auto server = serve(description(all_features()));
  SourceSettings settings{.width = 320, .height = 240, .exposure_us = 8000, .gain_db = 3};
  settings.black_level = 12;
  settings.white_balance = {150, 100, 220};
  settings.pixel_format = "Mono8";
  AravisCamera camera(kAddress, settings);
  std::vector<std::string> got;
  for (const LockedFeature& feature : camera.locks()) {
    EXPECT_TRUE(feature.holds) << feature.feature;
    got.push_back(feature.feature + "=" + feature.got);
  }
  EXPECT_THAT(got, ::testing::ElementsAre("ExposureAuto=Off", "GainAuto=Off", "BalanceWhiteAuto=Off",
                                          "ExposureTime=8000", "GainRaw=3", "BlackLevel=12", "BalanceRatioRaw[Red]=150",
                                          "BalanceRatioRaw[Green]=100", "BalanceRatioRaw[Blue]=220"));
  EXPECT_TRUE(camera.exposure().locked);
  EXPECT_NEAR(camera.exposure().exposure_s, 0.008, 1e-9);
  camera.start();
  const auto frame = camera.grab(std::chrono::milliseconds(2000));
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->image.format, PixelFormat::kMono8);
}

TEST_F(CameraLock, AValueThatTheCameraDoesNotTakeIsNamed) {
  const auto server = serve(description(all_features()));
  EXPECT_THAT(refusal({.gain_db = 3.7}), AllOf(HasSubstr("GainRaw: asked 3.7, got 3"), HasSubstr(kAddress)));
  SourceSettings settings;
  settings.pixel_format = "RGB8";
  EXPECT_THAT(refusal(settings), AllOf(HasSubstr("PixelFormat: asked RGB8"), HasSubstr("Mono8, BayerRG8")));
}

TEST_F(CameraLock, NumbersAreSetAsTheCameraDescribesThem) {
  struct Case {
    std::string exposure, gain;
  };
  for (const Case& c : {Case{"ExposureTime", "Gain"}, {"ExposureTimeAbs", "GainAbs"}, {"ExposureTimeRaw", "GainRaw"}})
    for (const std::string kind : {"Integer", "Float"}) {
      SCOPED_TRACE(c.exposure + " " + kind);
      const auto server = serve(description("", number(c.exposure, 0x120, kind) + number(c.gain, 0x110, kind)));
      const AravisCamera camera(kAddress, {.exposure_us = 8000, .gain_db = 3});
      EXPECT_EQ(lock_failures(camera.locks()), "");
      EXPECT_NEAR(camera.exposure().exposure_s, 0.008, 1e-9);
      EXPECT_NEAR(camera.exposure().gain_db, 3, 1e-9);
      EXPECT_TRUE(camera.exposure().locked);
    }
}

TEST_F(CameraLock, AnExposureIsInTheUnitThatTheCameraNames) {
  std::string exposure = number("ExposureTime", 0x120);
  exposure.insert(exposure.find("<pValue>"), "<Unit>ms</Unit>");
  const auto server = serve(description("", exposure));
  EXPECT_NEAR(AravisCamera(kAddress, {.exposure_us = 8000}).exposure().exposure_s, 0.008, 1e-9);
}

TEST_F(CameraLock, WhatAnotherProgramLeftIsSetBackAndReported) {
  const auto server = serve(description(
      choice("TriggerSelector", "TriggerSelectorNumberReg", {"FrameStart", "AcquisitionStart"}, {0, 1}) +
      number("TriggerSelectorNumber", 0x420) + choice("TriggerMode", "TriggerModeNumberReg", {"On", "Off"}, {0, 1}) +
      number("TriggerModeNumber", 0x424) +
      choice("ExposureMode", "ExposureModeNumberReg", {"TriggerWidth", "Timed"}, {0, 1}) +
      number("ExposureModeNumber", 0x428) + switched_on("ReverseX", 0x42c) + switched_on("ReverseY", 0x430) +
      number("BinningHorizontal", 0x434) + number("DecimationVertical", 0x438) +
      choice("TestPattern", "TestPatternNumberReg", {"Bars", "Off"}, {0, 1}) + number("TestPatternNumber", 0x43c)));
  {
    const AravisCamera camera(kAddress, {.width = 320, .height = 240});
    EXPECT_EQ(
        camera.changes(),
        "TriggerMode[FrameStart] was On, is Off; ExposureMode was TriggerWidth, is Timed; TestPattern was Bars, is "
        "Off; ReverseX was on, is off; ReverseY was on, is off; BinningHorizontal was 0, is 1; DecimationVertical "
        "was 0, is 1");
  }
  EXPECT_EQ(AravisCamera(kAddress, {.width = 320, .height = 240}).changes(), "") << "it is as it should be";
}

TEST_F(CameraLock, AStateThatStaysIsNamed) {
  const auto server =
      serve(description("<Boolean Name=\"ReverseX\"><pValue>Stuck</pValue><OnValue>2</OnValue>"
                        "<OffValue>0</OffValue></Boolean>\n<IntSwissKnife Name=\"Stuck\"><pVariable "
                        "Name=\"W\">WidthReg</pVariable><Formula>2 + 0 * W</Formula></IntSwissKnife>\n"));
  EXPECT_THAT(refusal({}), HasSubstr("ReverseX: asked off, got on"));
}

TEST_F(CameraLock, ARegionInTheMiddleOfTheSensorIsSetBack) {
  const auto server = serve(description(""));
  {
    const AravisCamera camera(kAddress, {.width = 160, .height = 120});
    EXPECT_EQ(camera.changes(), "");
  }
  // As a vendor's program would leave it.
  GError* error = nullptr;
  ArvCamera* vendor = arv_camera_new(kAddress, &error);
  ASSERT_TRUE(vendor);
  arv_camera_set_region(vendor, 40, 30, 160, 120, &error);
  g_object_unref(vendor);
  ASSERT_FALSE(error);
  EXPECT_THAT(AravisCamera(kAddress, {}).changes(), HasSubstr("region was 160 x 120 at 40, 30, is 320 x 240 at 0, 0"));
}

TEST_F(CameraLock, WhatCannotBeSwitchedOffIsNamed) {
  // A camera that says that its gain is automatic whatever it is told.
  const auto server = serve(description(choice("GainAuto", "Stuck", {"Off", "Continuous"}, {0, 2}) +
                                        "<IntSwissKnife Name=\"Stuck\"><pVariable Name=\"W\">WidthReg</pVariable>"
                                        "<Formula>2 + 0 * W</Formula></IntSwissKnife>\n"));
  EXPECT_THAT(refusal({}), HasSubstr("GainAuto: asked Off, got Continuous"));
}

TEST_F(CameraLock, AFeatureThatTheCameraLacksIsNamedWhereAValueIsAskedFor) {
  const auto server = serve("");
  EXPECT_EQ(refusal({}), "accepted: ");
  SourceSettings settings;
  settings.black_level = 5;
  EXPECT_THAT(refusal(settings),
              AllOf(HasSubstr("BlackLevel: asked 5"), HasSubstr("looked for BlackLevel, BlackLevelAbs")));
  settings = {};
  settings.white_balance = {1, 1, 1};
  EXPECT_THAT(refusal(settings), HasSubstr("BalanceRatio: asked 1, 1, 1"));
}

TEST(CameraFeatures, RealCamerasHaveThemOrTheirAbsenceIsExplained) {
  const std::filesystem::path folder = shared_data("genicam_xml");
  if (folder.empty()) GTEST_SKIP() << "no descriptions of cameras here";
  struct Expected {
    const char* file;
    const char* exposure;
    const char* gain;
    const char* black;
    const char* balance;
  };
  constexpr Expected kCameras[] = {
      {"AVT_Mako_G234C.xml", "ExposureTimeAbs", "Gain", "BlackLevel", "BalanceRatioAbs"},
      {"AVT_Prosilica_GC655C.xml", "ExposureTimeAbs", "Gain", "", "BalanceRatioAbs"},
      {"Basler-acA1920-25gm.xml", "ExposureTime", "Gain", "BlackLevel", "BalanceRatioAbs"},
      {"FLIR-BFS-PGE-50S4C.xml", "ExposureTime", "Gain", "BlackLevel", "BalanceRatio"},
      {"FLIR_FL3_U3_13S2C.xml", "ExposureTime", "Gain", "BlackLevel", "BalanceRatio"},
      {"FLIR_SC6700.xml", "", "", "", ""},  // an infrared camera
      {"Orca_Fire_C16240-20UP.xml", "ExposureTime", "", "", ""},
      {"PGR_Blackfly_20E4C.xml", "ExposureTime", "Gain", "BlackLevel", "BalanceRatio"},
  };
  for (const Expected& camera : kCameras) {
    const std::string xml = read_file(folder / camera.file);
    const auto has = [&](const std::string& name) { return xml.find("Name=\"" + name + "\"") != std::string::npos; };
    const std::pair<CameraSetting, std::string> settings[] = {{CameraSetting::kExposure, camera.exposure},
                                                              {CameraSetting::kGain, camera.gain},
                                                              {CameraSetting::kBlackLevel, camera.black},
                                                              {CameraSetting::kWhiteBalance, camera.balance},
                                                              {CameraSetting::kPixelFormat, "PixelFormat"}};
    for (const auto& [setting, name] : settings) {
      const CameraFeature found = find_feature(setting, has);
      EXPECT_EQ(found.name, name) << camera.file;
      EXPECT_EQ(found.absence.empty(), !name.empty()) << camera.file;
    }
  }
}

}  // namespace
}  // namespace sheen
