// SPDX-License-Identifier: Apache-2.0
#include "tests/support/process.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace sheen::testing {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{5};

std::filesystem::path make_output_file() {
  std::string name = (std::filesystem::temp_directory_path() / "sheen_output_XXXXXX").string();
  const int fd = ::mkstemp(name.data());
  if (fd < 0) throw std::runtime_error("no temporary file for a process's output");
  ::close(fd);
  return name;
}

std::vector<std::string> environment_with(const std::map<std::string, std::string>& changes) {
  std::vector<std::string> result;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    if (!changes.contains(text.substr(0, text.find('=')))) result.push_back(text);
  }
  for (const auto& [name, value] : changes)
    if (!value.empty()) result.push_back(name + "=" + value);
  return result;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

}  // namespace

Process::Process(const std::vector<std::string>& arguments, const ProcessOptions& options)
    : output_(make_output_file()) {
  // All memory is had before the fork: the child of a process with threads may only make system calls.
  std::vector<std::string> words = arguments, variables = environment_with(options.environment);
  const std::vector<char*> argv = pointers(words), envp = pointers(variables);
  const int out = ::open(output_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  pid_ = ::fork();
  if (pid_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::dup2(out, STDOUT_FILENO);
    ::dup2(out, STDERR_FILENO);
    if (options.file_bytes) {
      const rlimit limit{*options.file_bytes, *options.file_bytes};
      ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ::execvpe(argv[0], argv.data(), envp.data());
    ::_exit(127);
  }
  ::close(out);
  if (pid_ < 0) throw std::runtime_error("no process for " + arguments[0]);
}

Process::~Process() {
  kill();
  std::error_code ignored;
  std::filesystem::remove(output_, ignored);
}

std::optional<ProcessEnd> Process::wait(std::chrono::milliseconds timeout) {
  for (const auto deadline = Clock::now() + timeout; !end_; std::this_thread::sleep_for(kLook)) {
    int status = 0;
    if (::waitpid(pid_, &status, WNOHANG) == pid_)
      end_ = WIFEXITED(status) ? ProcessEnd{WEXITSTATUS(status), 0} : ProcessEnd{-1, WTERMSIG(status)};
    else if (Clock::now() >= deadline)
      return std::nullopt;
  }
  return end_;
}

void Process::signal(int number) {
  if (running()) ::kill(pid_, number);
}

void Process::kill() {
  signal(SIGKILL);
  while (!wait(std::chrono::milliseconds(1000))) {
  }
}

std::string Process::output() const {
  std::ostringstream text;
  text << std::ifstream(output_).rdbuf();
  return text.str();
}

bool Process::prints(const std::string& text, std::chrono::milliseconds timeout) {
  for (const auto deadline = Clock::now() + timeout;; std::this_thread::sleep_for(kLook)) {
    const bool ended = !running();
    if (output().find(text) != std::string::npos) return true;
    if (ended || Clock::now() >= deadline) return false;
  }
}

int free_port() {
  const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  const bool bound = fd >= 0 && ::bind(fd, reinterpret_cast<sockaddr*>(&address), size) == 0 &&
                     ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  if (fd >= 0) ::close(fd);
  if (!bound) throw std::runtime_error("no free port");
  return ntohs(address.sin_port);
}

}  // namespace sheen::testing
