// SPDX-License-Identifier: Apache-2.0
#include "tests/reconstructor/monitor/exposition_parser.h"

#include <limits>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>

namespace sheen {
namespace {

class LineReader {
 public:
  explicit LineReader(const std::string& line) : line_(line) {}

  std::string word(const char* pattern) {
    std::smatch match;
    const std::string rest = line_.substr(at_);
    if (!std::regex_search(rest, match, std::regex(pattern), std::regex_constants::match_continuous))
      throw std::runtime_error("expected " + std::string(pattern) + " at " + std::to_string(at_) + " of: " + line_);
    at_ += match.str().size();
    return match.str();
  }
  bool next_is(char c) {
    if (at_ >= line_.size() || line_[at_] != c) return false;
    ++at_;
    return true;
  }
  std::string quoted() {
    if (!next_is('"')) throw std::runtime_error("expected a quote: " + line_);
    std::string value;
    while (!next_is('"')) {
      if (at_ >= line_.size()) throw std::runtime_error("unclosed quote: " + line_);
      char c = line_[at_++];
      if (c == '\\') {
        const char escape = at_ < line_.size() ? line_[at_++] : '?';
        if (escape != '\\' && escape != '"' && escape != 'n') throw std::runtime_error("unknown escape: " + line_);
        c = escape == 'n' ? '\n' : escape;
      }
      value += c;
    }
    return value;
  }
  std::string rest() const { return line_.substr(at_); }

 private:
  const std::string& line_;
  std::size_t at_ = 0;
};

double to_number(const std::string& text) {
  if (text == "NaN") return std::numeric_limits<double>::quiet_NaN();
  if (text == "+Inf") return std::numeric_limits<double>::infinity();
  if (text == "-Inf") return -std::numeric_limits<double>::infinity();
  std::size_t used = 0;
  const double value = std::stod(text, &used);
  if (used != text.size()) throw std::runtime_error("not a number: " + text);
  return value;
}

std::string family_of(const std::string& sample, const std::map<std::string, std::string>& types) {
  for (const std::string suffix : {"_sum", "_count"}) {
    if (!sample.ends_with(suffix)) continue;
    const std::string base = sample.substr(0, sample.size() - suffix.size());
    if (const auto it = types.find(base); it != types.end() && it->second == "summary") return base;
  }
  return sample;
}

ExpositionSample parse_sample(const std::string& line) {
  LineReader reader(line);
  ExpositionSample sample;
  sample.name = reader.word("[a-zA-Z_:][a-zA-Z0-9_:]*");
  if (reader.next_is('{')) {
    do {
      const std::string label = reader.word("[a-zA-Z_][a-zA-Z0-9_]*");
      reader.word("=");
      if (!sample.labels.emplace(label, reader.quoted()).second) throw std::runtime_error("label twice: " + line);
    } while (reader.next_is(','));
    reader.word("\\}");
  }
  reader.word(" ");
  sample.value = to_number(reader.rest());
  return sample;
}

}  // namespace

double Exposition::value(const std::string& name, const std::map<std::string, std::string>& labels) const {
  for (const ExpositionSample& sample : samples)
    if (sample.name == name && sample.labels == labels) return sample.value;
  return std::numeric_limits<double>::quiet_NaN();
}

Exposition parse_exposition(const std::string& text) {
  if (text.empty() || text.back() != '\n') throw std::runtime_error("the last line must end with a newline");
  Exposition exposition;
  std::set<std::pair<std::string, std::map<std::string, std::string>>> seen;
  std::set<std::string> finished;
  std::string family;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    static const std::regex type("# TYPE ([a-zA-Z_:][a-zA-Z0-9_:]*) (counter|gauge|summary|histogram|untyped)");
    if (line.starts_with("# HELP ")) continue;
    if (std::regex_match(line, match, type)) {
      if (!exposition.types.emplace(match[1], match[2]).second) throw std::runtime_error("type twice: " + line);
      continue;
    }
    if (line.empty() || line[0] == '#') throw std::runtime_error("neither HELP, TYPE nor a sample: " + line);
    ExpositionSample sample = parse_sample(line);
    const std::string its_family = family_of(sample.name, exposition.types);
    if (!exposition.types.contains(its_family)) throw std::runtime_error("sample before its TYPE: " + line);
    if (its_family != family && !finished.insert(its_family).second)
      throw std::runtime_error("the lines of a family must stand together: " + line);
    family = its_family;
    if (!seen.emplace(sample.name, sample.labels).second) throw std::runtime_error("sample twice: " + line);
    exposition.samples.push_back(std::move(sample));
  }
  return exposition;
}

}  // namespace sheen
