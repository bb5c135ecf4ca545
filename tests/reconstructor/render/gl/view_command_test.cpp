// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <iterator>
#include <sstream>

#include "common/base/command_line.h"
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
  /// The exit status. `error_` is then what was printed on standard error.
  int run(const std::string& arguments) {
    CommandLine program("prog", "");
    add_view_command(program);
    std::istringstream line("prog view " + arguments);
    const std::vector<std::string> words{std::istream_iterator<std::string>(line), {}};
    std::vector<const char*> argv;
    for (const std::string& word : words) argv.push_back(word.c_str());
    testing::internal::CaptureStderr();
    const int status = program.run(static_cast<int>(argv.size()), argv.data());
    error_ = testing::internal::GetCapturedStderr();
    return status;
  }
  std::string model() {
    save_model(*SyntheticLightField({.around = 24, .across = 8}).snapshot(), folder_.path() / "model");
    return (folder_.path() / "model").string();
  }
  TempFolder folder_;
  std::string error_;
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
  ASSERT_EQ(run(folder + " --screenshot " + picture + " --mode heuristic --size 320x240 --eye 0.2,0.1,0.15"), 0)
      << error_;
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
  EXPECT_EQ(run(folder), 1);
  EXPECT_NE(error_.find("maps.exr"), std::string::npos) << error_;
}

TEST_F(ViewCommand, SaysWhatIsWrongWithItsArguments) {
  const std::string folder = model();
  EXPECT_EQ(run("/nowhere --screenshot x.png"), 1) << error_;
  for (const char* size : {"12", "0x100", "100x", "100x100x100", "99999x10", "-5x200", "axb"})
    EXPECT_EQ(run(folder + " --size " + size), 2) << size << error_;
  EXPECT_EQ(run(folder + " --mode Split"), 2) << error_;
  EXPECT_EQ(run(folder + " --eye 1,2"), 2) << error_;
  EXPECT_EQ(run(""), 2) << error_;
}

}  // namespace
}  // namespace sheen
