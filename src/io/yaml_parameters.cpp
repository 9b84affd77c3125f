#include "matchbox_slam/io/yaml_parameters.hpp"

#include <fmt/core.h>
#include <yaml-cpp/anchor.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <sstream>

#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

// An alias to a node around it makes YAML that never ends; nobody nests parameters this deep.
constexpr int kMaxDepth = 32;

bool has_empty_part(const std::string& key) {
  return key.empty() || key.front() == '/' || key.back() == '/' ||
         key.find("//") != std::string::npos;
}

/// Walks one YAML document and collects its scalars and lists.
class YamlReader {
 public:
  explicit YamlReader(std::string source) : source_(std::move(source)) {}

  void read_map(const YAML::Node& map, const std::string& prefix, int depth) {
    if (depth > kMaxDepth) {
      fail(map, fmt::format("maps are nested more than {} deep", kMaxDepth));
    }
    for (const auto& entry : map) {
      if (!entry.first.IsScalar() || has_empty_part(entry.first.Scalar())) {
        fail(entry.first, "a name has to be text whose parts, joined with '/', are not empty");
      }
      read_value(entry.second, entry.first, prefix + entry.first.Scalar(), depth);
    }
  }

  [[nodiscard]] const Parameters& parameters() const { return parameters_; }

  /// Where each of them is.
  [[nodiscard]] const std::map<std::string, std::string>& places() const { return places_; }

  [[noreturn]] void fail(const YAML::Node& node, const std::string& text) const {
    fail(node.Mark(), text);
  }

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& text) const {
    throw ConfigurationError(fmt::format("{}: {}", place_of(mark), text));
  }

 private:
  [[nodiscard]] std::string place_of(const YAML::Mark& mark) const {
    return mark.line < 0 ? source_ : fmt::format("{}:{}", source_, mark.line + 1);
  }

  void read_value(const YAML::Node& node, const YAML::Node& name, const std::string& key,
                  int depth) {
    switch (node.Type()) {
      case YAML::NodeType::Map:
        return read_map(node, key + "/", depth + 1);
      case YAML::NodeType::Sequence:
        return store(name, key, list_value(node, key));
      case YAML::NodeType::Scalar:
        return store(name, key, scalar_value(node));
      default:
        fail(name, fmt::format("'{}' has no value; give one, or leave the line out", key));
    }
  }

  void store(const YAML::Node& name, const std::string& key, const ParameterValue& value) {
    if (parameters_.find(key) != nullptr) {
      fail(name, fmt::format("'{}' is given twice", key));
    }
    parameters_.set(key, value);
    places_[key] = place_of(name.Mark());
  }

  [[nodiscard]] static ParameterValue scalar_value(const YAML::Node& node) {
    const bool is_plain = node.Tag().empty() || node.Tag() == "?";
    return is_plain ? parse_parameter_value(node.Scalar()) : ParameterValue(node.Scalar());
  }

  [[nodiscard]] ParameterValue list_value(const YAML::Node& list, const std::string& key) const {
    std::vector<double> numbers;
    std::vector<std::string> texts;
    for (const auto& element : list) {
      if (!element.IsScalar()) {
        fail(list, fmt::format("'{}' is a list of something else than numbers or texts", key));
      }
      if (const std::optional<double> number = number_in(scalar_value(element))) {
        numbers.push_back(*number);
      }
      texts.push_back(element.Scalar());
    }
    if (numbers.size() == texts.size()) {
      return numbers;
    }
    return texts;
  }

  std::string source_;
  Parameters parameters_;
  std::map<std::string, std::string> places_;
};

/// Reads a document for its extent alone.
class Unheard : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark& /*mark*/) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnAlias(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnScalar(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                const std::string& /*value*/) override {}
  void OnSequenceStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/,
                       YAML::anchor_t /*anchor*/, YAML::EmitterStyle::value /*style*/) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {}
  void OnMapEnd() override {}
};

/// Whether anything follows the first document. YAML::LoadAll would tell, but yaml-cpp 0.7 adds
/// documents without end to some texts that are no YAML.
bool goes_on_after_a_document(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Unheard unheard;
  parser.HandleNextDocument(unheard);
  return static_cast<bool>(parser);
}

YAML::Node load_document(const std::string& text, const YamlReader& reader) {
  try {
    if (goes_on_after_a_document(text)) {
      reader.fail(YAML::Mark::null_mark(),
                  "a second YAML document begins after the first; only one is read");
    }
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    reader.fail(error.mark, "not YAML: " + error.msg);
  }
}

std::string read_configuration(const std::string& path) {
  try {
    return read_file(path);
  } catch (const FileError& error) {
    throw ConfigurationError(error.what());
  }
}

YamlReader read_document(const std::string& text, const std::string& source) {
  YamlReader reader(source);
  const YAML::Node document = load_document(text, reader);
  if (document.IsMap()) {
    reader.read_map(document, "", 0);
  } else if (!document.IsNull()) {
    reader.fail(document, "has to be a map of names to values, such as 'matcher: monte_carlo'");
  }
  return reader;
}

}  // namespace

Parameters parse_yaml_parameters(const std::string& text, const std::string& source) {
  return read_document(text, source).parameters();
}

Parameters read_yaml_parameters(const std::vector<std::string>& paths) {
  Parameters parameters;
  for (const std::string& path : paths) {
    parameters.merge(parse_yaml_parameters(read_configuration(path), path));
  }
  return parameters;
}

std::map<std::string, std::string> places_in_yaml(const std::vector<std::string>& paths) {
  std::map<std::string, std::string> places;
  for (const std::string& path : paths) {
    const YamlReader reader = read_document(read_configuration(path), path);
    for (const auto& [name, place] : reader.places()) {
      places[name] = place;
    }
  }
  return places;
}

std::vector<ParameterEntry> read_yaml_list(const std::string& path) {
  const YamlReader reader(path);
  const YAML::Node document = load_document(read_configuration(path), reader);
  if (!document.IsSequence() && !document.IsNull()) {
    reader.fail(document, "has to be a list, each entry after a '-'");
  }
  std::vector<ParameterEntry> entries;
  for (const YAML::Node& entry : document) {
    if (!entry.IsMap()) {
      reader.fail(entry, "has to be a map of names to values");
    }
    YamlReader entry_reader(path);
    entry_reader.read_map(entry, "", 0);
    entries.push_back({entry.Mark().line + 1, entry_reader.parameters()});
  }
  return entries;
}

Parameters parse_overrides(const std::vector<std::string>& assignments) {
  Parameters parameters;
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    const std::string key = assignment.substr(0, equals);
    if (equals == std::string::npos || has_empty_part(key)) {
      throw ConfigurationError(fmt::format("'{}' is not name=value", assignment));
    }
    if (key.find('.') != std::string::npos) {
      std::string with_slashes = key;
      std::replace(with_slashes.begin(), with_slashes.end(), '.', '/');
      throw ConfigurationError(fmt::format("'{}': the parts of a name are joined with '/': '{}'",
                                           assignment, with_slashes));
    }
    const std::string value = assignment.substr(equals + 1);
    if (value.empty()) {
      parameters.set(key, std::string());
      continue;
    }
    // The name is not part of the YAML text: it may hold what YAML would read as its own.
    const Parameters read =
        parse_yaml_parameters("value: " + value, fmt::format("'{}'", assignment));
    for (const auto& [name, given] : read.values()) {
      if (name != "value" && name.rfind("value/", 0) != 0) {  // after a line break in the value
        throw ConfigurationError(fmt::format(
            "'{}' holds more than one value; give each name=value by itself", assignment));
      }
      parameters.set(key + name.substr(std::string("value").size()), given);
    }
  }
  return parameters;
}

std::string to_yaml(const Parameters& parameters) {
  std::string text;
  std::vector<std::string> before;
  for (const auto& [key, value] : parameters.values()) {
    const std::vector<std::string> parts = split(key, '/');
    std::string section;
    bool is_open = true;  // the section, by the value before
    for (std::size_t depth = 0; depth < parts.size(); ++depth) {
      const std::string name =
          std::string(2 * depth, ' ') + to_string(ParameterValue(parts[depth]));
      if (depth + 1 == parts.size()) {
        text += fmt::format("{}: {}\n", name, to_string(value));
        break;
      }
      section += (depth == 0 ? "" : "/") + parts[depth];
      if (parameters.find(section) != nullptr) {
        throw ConfigurationError(
            fmt::format("'{}' is both a value and a section of others", section));
      }
      is_open = is_open && depth + 1 < before.size() && parts[depth] == before[depth];
      text += is_open ? "" : name + ":\n";
    }
    before = parts;
  }
  return text;
}

}  // namespace matchbox_slam
