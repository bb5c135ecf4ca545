// SPDX-License-Identifier: Apache-2.0
#include "common/base/progress.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <functional>

namespace sheen {
namespace {

using testing::HasSubstr;

TEST(Progress, ShowsShareRateAndTimeLeft) {
  EXPECT_EQ(progress_line("building", 45, 90, 9.0, 80),
            "building [####################....................] 45/90  50 %  5.0/s  9 s left");
}

TEST(Progress, FitsNarrowTerminals) {
  for (int width = 0; width < 100; ++width)
    EXPECT_LE(progress_line("building", 123456, 1234567, 3.0, width).size(), static_cast<std::size_t>(width));
}

TEST(Progress, StartAndEndAndUnknownTotal) {
  EXPECT_THAT(progress_line("x", 0, 10, 0.0, 79), HasSubstr("0/10  0 %"));
  EXPECT_THAT(progress_line("x", 10, 10, 2.0, 79), HasSubstr("10/10  100 %  5.0/s"));
  EXPECT_THAT(progress_line("x", 20, 10, 2.0, 79), HasSubstr("20/10  100 %"));
  EXPECT_EQ(progress_line("x", 20, 0, 2.0, 79), "x 20  10/s");
  EXPECT_EQ(progress_line("saving", 0, 0, 2.0, 79), "saving ...") << "nobody knows how far it is";
}

TEST(Progress, SaysNothingOfShortWorkInAPipe) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_NONBLOCK), 0);
  std::FILE* stream = ::fdopen(ends[1], "w");
  {
    Progress progress("x", 3, stream);
    for (std::uint64_t i = 0; i <= 3; ++i) progress.update(i);
  }
  std::fclose(stream);
  char byte = 0;
  EXPECT_EQ(::read(ends[0], &byte, 1), 0);
  ::close(ends[0]);
}

/// What a terminal gets to see of what `print` writes to it.
std::string on_a_terminal(const std::function<void(std::FILE*)>& print) {
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal < 0 || ::grantpt(terminal) != 0 || ::unlockpt(terminal) != 0) return {};
  std::FILE* stream = ::fopen(::ptsname(terminal), "w");
  if (!stream) return {};
  print(stream);
  const int written = ::dup(::fileno(stream));  // a terminal that nobody writes to may forget what it was told
  std::fclose(stream);
  ::fcntl(terminal, F_SETFL, O_NONBLOCK);
  std::string text;
  pollfd more{terminal, POLLIN, 0};
  while (::poll(&more, 1, 500) > 0) {  // what was written at once may come in parts
    std::array<char, 512> seen{};
    const ssize_t length = ::read(terminal, seen.data(), seen.size());
    if (length <= 0) break;
    text.append(seen.data(), static_cast<std::size_t>(length));
  }
  ::close(written);
  ::close(terminal);
  return text;
}

TEST(Progress, DrawsOnATerminalAndCleansUp) {
  const std::string text = on_a_terminal([](std::FILE* stream) {
    Progress progress("frames", 4, stream);
    progress.update(1);
  });
  if (text.empty()) GTEST_SKIP() << "no pseudo terminals here";
  EXPECT_THAT(text, HasSubstr("1/4  25 %"));
  EXPECT_THAT(text, testing::EndsWith("\r\x1b[K"));
}

TEST(Progress, SharesNoLineWithWhatIsPrintedMeanwhile) {
  const std::string text = on_a_terminal([](std::FILE* stream) {
    Progress progress("frames", 4, stream);
    progress.update(1);
    {
      const ProgressPause pause;
      std::fputs("figure 4", stream);
    }
  });
  if (text.empty()) GTEST_SKIP() << "no pseudo terminals here";
  EXPECT_THAT(text, testing::ContainsRegex("1/4[^\r]*\r\x1b\\[Kfigure 4"));
}

}  // namespace
}  // namespace sheen
