// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/image/image.h"
#include "common/image/image_io.h"
#include "common/image/raw_image.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/models/surface_light_field/kind.h"
#include "reconstructor/render/gl/viewer_window.h"
#include "tests/reconstructor/render/gl/synthetic_light_field.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

class ViewCommand : public testing::Test {
 protected:
  void run(const std::string& arguments) {
    CLI::App app;
    add_view_command(app);
    app.parse("view " + arguments);
  }
  std::string model() {
    save_model(*SyntheticLightField({.around = 24, .across = 8}).snapshot(), folder_.path() / "model");
    return (folder_.path() / "model").string();
  }
  TempFolder folder_;
};

TEST_F(ViewCommand, WritesWhatTheWindowDraws) {
  const std::string folder = model(), picture = (folder_.path() / "view.png").string();
  ImageU8 expected;
  try {
    ViewerWindow window(surface_light_field_kind(), {.width = 320, .height = 240, .visible = false});
    ViewerState state;
    state.snapshot = load_model(folder);
    window.controls().mode = ViewMode::kHeuristic;
    window.controls().frame(state.snapshot->shared_mesh());
    window.controls().orbit.place({0.2, 0.1, 0.15});
    expected = window.draw_once(state);
  } catch (const DeviceError& error) {
    GTEST_SKIP() << error.what();
  }
  run(folder + " --screenshot " + picture + " --mode heuristic --size 320x240 --eye 0.2,0.1,0.15");
  const RawImage written = read_image(picture);
  ASSERT_EQ(written.width, 320);
  ASSERT_EQ(written.height, 240);
  EXPECT_TRUE(std::equal(written.bytes.begin(), written.bytes.end(), expected.data()));
}

TEST_F(ViewCommand, ADamagedModelEndsTheWindowThatWaitsForIt) {
  const std::string folder = model();
  const std::string maps = (folder_.path() / "model" / "maps.exr").string();
  write_file(maps, "not an EXR file");
  try {
    ViewerWindow window(surface_light_field_kind(), {.width = 64, .height = 64, .visible = false});
  } catch (const DeviceError& error) {
    GTEST_SKIP() << error.what();
  }
  try {
    run(folder);
    ADD_FAILURE() << "it was shown";
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("maps.exr"), std::string::npos) << error.what();
  }
}

TEST_F(ViewCommand, SaysWhatIsWrongWithItsArguments) {
  const std::string folder = model();
  EXPECT_THROW(run("/nowhere --screenshot x.png"), FileError);
  for (const char* size : {"12", "0x100", "100x", "100x100x100", "99999x10", "-5x200", "axb"})
    EXPECT_THROW(run(folder + " --size " + size), ConfigError) << size;
  EXPECT_THROW(run(folder + " --mode Split"), ConfigError);
  EXPECT_THROW(run(folder + " --eye 1,2"), CLI::ParseError);
  EXPECT_THROW(run(""), CLI::ParseError);
}

}  // namespace
}  // namespace sheen
