#include "matchbox_slam/io/map_file.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iomanip>
#include <locale>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

/// Numbers as C's "%f" prints them, which is what map_saver uses.
std::ostringstream fixed_stream(int decimals = 6) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream << std::fixed << std::setprecision(decimals);
  return stream;
}

std::string pgm_of(const MapImage& map) {
  std::ostringstream header = fixed_stream(3);
  header << "P5\n# CREATOR: matchbox_slam " << map.resolution << " m/pix\n"
         << map.width << ' ' << map.height << "\n255\n";
  std::string bytes = header.str();
  bytes.append(map.pixels.begin(), map.pixels.end());
  return bytes;
}

std::string yaml_of(const MapImage& map, const std::string& image_name) {
  std::ostringstream text = fixed_stream();
  text << "image: " << to_string(ParameterValue(image_name)) << "\nresolution: " << map.resolution
       << "\norigin: [" << map.origin.x << ", " << map.origin.y << ", " << map.origin.theta
       << "]\nnegate: " << (map.negate ? 1 : 0)
       << "\noccupied_thresh: " << to_string(map.occupied_threshold)
       << "\nfree_thresh: " << to_string(map.free_threshold) << "\n\n";
  return text.str();
}

/// Reads the head of a PGM, token by token; comments go from '#' to the end of the line.
class PgmHeader {
 public:
  PgmHeader(const std::string& bytes, const std::string& path) : bytes_(bytes), path_(path) {
    if (bytes_.compare(0, 2, "P5") != 0) {
      fail("is not a binary PGM (it does not begin with P5)");
    }
    position_ = 2;
    width_ = read_number("width", 1 << 20);
    height_ = read_number("height", 1 << 20);
    if (const int brightest = read_number("brightest value", 65535); brightest != 255) {
      fail("has the brightest value " + std::to_string(brightest) + "; allowed: 255");
    }
    ++position_;  // the one white space that ends the head
    if (bytes_.size() < position_ + pixel_count()) {
      fail("is cut off: " + std::to_string(width_) + " x " + std::to_string(height_) +
           " pixels are announced, " +
           std::to_string(bytes_.size() - std::min(bytes_.size(), position_)) + " are there");
    }
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  [[nodiscard]] std::vector<std::uint8_t> pixels() const {
    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(position_);
    return {begin, begin + static_cast<std::ptrdiff_t>(pixel_count())};
  }

 private:
  [[noreturn]] void fail(const std::string& text) const {
    throw FileError("'" + path_ + "' " + text);
  }

  [[nodiscard]] std::size_t pixel_count() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }

  [[nodiscard]] bool at_digit() const {
    return position_ < bytes_.size() &&
           std::isdigit(static_cast<unsigned char>(bytes_[position_])) != 0;
  }

  void skip_space() {
    while (position_ < bytes_.size() &&
           (std::isspace(static_cast<unsigned char>(bytes_[position_])) != 0 ||
            bytes_[position_] == '#')) {
      position_ = bytes_[position_] == '#' ? std::min(bytes_.find('\n', position_), bytes_.size())
                                           : position_ + 1;
    }
  }

  int read_number(const char* name, int highest) {
    skip_space();
    int number = 0;
    while (at_digit() && number <= highest) {
      number = 10 * number + (bytes_[position_++] - '0');
    }
    if (number < 1 || number > highest) {
      fail(std::string("has no usable ") + name + " in its head; allowed: 1 to " +
           std::to_string(highest));
    }
    return number;
  }

  const std::string& bytes_;
  const std::string& path_;
  std::size_t position_ = 0;
  int width_ = 0;
  int height_ = 0;
};

/// The few values of a map's YAML file.
class MapYaml {
 public:
  explicit MapYaml(std::string path) : path_(std::move(path)) {
    const std::string text = read_file(path_);
    try {
      root_ = YAML::Load(text);
    } catch (const YAML::Exception& error) {
      throw FileError("'" + path_ + "' is not YAML: " + error.what());
    }
    if (!root_.IsMap()) {
      throw FileError("'" + path_ + "' is not the YAML of a map");
    }
  }

  template <typename Value>
  [[nodiscard]] Value get(const char* key) const {
    const YAML::Node node = root_[key];
    if (!node) {
      throw FileError("'" + path_ + "' has no '" + key + "'");
    }
    try {
      return node.as<Value>();
    } catch (const YAML::Exception&) {
      throw FileError("'" + path_ + "' has a '" + key + "' that cannot be read");
    }
  }

  [[nodiscard]] bool has(const char* key) const { return static_cast<bool>(root_[key]); }

  void require(bool condition, const std::string& text) const {
    if (!condition) {
      throw FileError("'" + path_ + "': " + text);
    }
  }

 private:
  std::string path_;
  YAML::Node root_;
};

Pose2 read_origin(const MapYaml& yaml) {
  const auto origin = yaml.get<std::vector<double>>("origin");
  yaml.require(origin.size() == 3, "origin has to be [x, y, yaw]");
  const Pose2 pose{origin[0], origin[1], origin[2]};
  yaml.require(pose.is_finite(), "origin has to be finite");
  return {pose.x, pose.y, wrap_angle(pose.theta)};
}

}  // namespace

std::vector<FileContents> map_files(const std::string& base_path, const MapImage& map) {
  const std::string image_path = base_path + ".pgm";
  const std::string image_name = std::filesystem::path(image_path).filename().string();
  return {{image_path, pgm_of(map)}, {base_path + ".yaml", yaml_of(map, image_name)}};
}

void write_map(const std::string& base_path, const MapImage& map) {
  replace_files(map_files(base_path, map));
}

MapImage read_map(const std::string& yaml_path) {
  const MapYaml yaml(yaml_path);
  yaml.require(!yaml.has("mode") || yaml.get<std::string>("mode") == "trinary",
               "mode has to be trinary or left out");
  MapImage map;
  map.resolution = yaml.get<double>("resolution");
  yaml.require(std::isfinite(map.resolution) && map.resolution > 0.0,
               "resolution has to be greater than 0");
  map.origin = read_origin(yaml);
  map.negate = yaml.get<int>("negate") != 0;
  map.occupied_threshold = yaml.get<double>("occupied_thresh");
  map.free_threshold = yaml.get<double>("free_thresh");

  // An absolute path of the image replaces the folder.
  const std::filesystem::path folder = std::filesystem::path(yaml_path).parent_path();
  const std::string image_path = (folder / yaml.get<std::string>("image")).string();
  const std::string bytes = read_file(image_path);
  const PgmHeader image(bytes, image_path);
  map.width = image.width();
  map.height = image.height();
  map.pixels = image.pixels();
  return map;
}

}  // namespace matchbox_slam
