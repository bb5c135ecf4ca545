// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/dataset_source.h"

#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "common/datasets/dataset.h"
#include "common/image/image_io.h"
#include "common/link/transport.h"
#include "tests/support/temp_folder.h"
#include "tracker/tracking_loop.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;

class SenderSink : public CaptureSink {
 public:
  explicit SenderSink(CaptureSender& sender) : sender_(sender) {}
  bool keep(Capture capture, milliseconds timeout) override { return sender_.keep(std::move(capture), timeout); }
  void live(Capture capture) override { sender_.live(std::move(capture)); }

 private:
  CaptureSender& sender_;
};

class DatasetReplay : public ::testing::Test {
 protected:
  DatasetReplay() {
    std::filesystem::create_directories(folder);
    const Camera camera{.width = 40, .height = 30, .fx = 50, .fy = 51, .cx = 19.5, .cy = 14.25};
    for (int i = 0; i < 6; ++i) {
      ImageU8 image(40, 30, 3);
      for (std::size_t k = 0; k < image.size(); ++k) image.data()[k] = static_cast<std::uint8_t>(k * (i + 3) + i);
      const std::string name = "view" + std::to_string(i) + ".png";
      write_png(folder / name, image);
      views.push_back({.name = name,
                       .image_path = folder / name,
                       .camera = camera,
                       .camera_from_object = look_at({0.1 * i, 0.2, 0.7}, {0, 0, 0}, {0, 0, 1}),
                       .purpose = i == 2 ? Purpose::kHeldOut : Purpose::kTraining});
    }
    write_transforms(folder / "transforms.json", views);
  }

  const TempFolder own;
  const std::filesystem::path& folder = own.path();
  std::vector<DatasetView> views;
};

TEST_F(DatasetReplay, CrossesTheNetworkExactlyAsReadFromTheFiles) {
  const Dataset dataset = load_dataset(folder);
  DatasetSource source(folder);
  CaptureSender sender({.endpoint = "tcp://127.0.0.1:*", .source_session = source.session()});
  CaptureReceiver receiver({.endpoint = sender.endpoint()});
  SenderSink sink(sender);
  const TrackingReport report = TrackingLoop(source, sink, std::nullopt, {}).run({.stop = [] { return false; }});
  EXPECT_EQ(report.kept, 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto received = receiver.next(milliseconds(5000));
    ASSERT_TRUE(received);
    EXPECT_FALSE(received->live);
    // Whatever else a capture holds takes the same way: compare what the wire writes, times aside.
    Capture got = received->capture, truth = read_capture(dataset, i);
    got.times = truth.times = {};
    const EncodedCapture a = encode_capture(got, MessageType::kKeep, Codec::kRaw);
    const EncodedCapture b = encode_capture(truth, MessageType::kKeep, Codec::kRaw);
    EXPECT_EQ(a.header, b.header) << "view " << i;
    EXPECT_EQ(a.blob, b.blob) << "view " << i;
  }
  EXPECT_TRUE(source.ended());
}

TEST_F(DatasetReplay, ABrokenImageIsLeftOutOrAnErrorThatNamesIt) {
  DatasetSource source(folder);
  std::filesystem::resize_file(folder / "view3.png", 60);  // after it was looked at
  EXPECT_EQ(DatasetSource(folder).session_size(), 5u);
  EXPECT_NE(DatasetSource(folder).remarks().find("left out: view3.png"), std::string::npos);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(source.next(milliseconds(10)));
  try {
    source.next(milliseconds(10));
    FAIL() << "view3.png is cut off";
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("view3.png"), std::string::npos);
  }
  EXPECT_THROW(DatasetSource(folder / "absent"), FileError);
}

}  // namespace
}  // namespace sheen
