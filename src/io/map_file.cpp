#include "matchbox_slam/io/map_file.hpp"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "io/png_image.hpp"
#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

std::string pgm_of(const MapImage& map) {
  std::string bytes = fmt::format("P5\n# CREATOR: matchbox_slam {:.3f} m/pix\n{} {}\n255\n",
                                  map.resolution, map.width, map.height);
  bytes.append(map.pixels.begin(), map.pixels.end());
  return bytes;
}

/// Lengths as map_saver prints them.
std::string yaml_of(const MapImage& map, const std::string& image_name) {
  return fmt::format(
      "image: {}\nresolution: {:f}\norigin: [{:f}, {:f}, {:f}]\nnegate: {}\n"
      "occupied_thresh: {}\nfree_thresh: {}\n\n",
      to_string(ParameterValue(image_name)), map.resolution, map.origin.x, map.origin.y,
      map.origin.theta, map.negate ? 1 : 0, to_string(map.occupied_threshold),
      to_string(map.free_threshold));
}

/// The pixels of a PGM that are written as numbers.
void read_text_pixels(const std::string& path, std::istream& stream, MapImage& map) {
  const std::size_t count =
      static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
  int pixel = 0;
  while (map.pixels.size() < count && stream >> pixel && pixel >= 0 && pixel <= 255) {
    map.pixels.push_back(static_cast<std::uint8_t>(pixel));
  }
  if (map.pixels.size() < count) {
    throw FileError(fmt::format(
        "'{}' is cut off or damaged: {} x {} pixels are announced, {} are there, each 0 to 255",
        path, map.width, map.height, map.pixels.size()));
  }
}

/// Reads size and pixels. Comments in the head go from '#' to the end of the line.
void read_pgm(const std::string& path, const std::string& bytes, MapImage& map) {
  std::istringstream stream(bytes);
  stream.imbue(std::locale::classic());
  const auto require = [&path](bool condition, const std::string& text) {
    if (!condition) {
      throw FileError(fmt::format("'{}' {}", path, text));
    }
  };
  const auto read_number = [&](const std::string& name, int highest) {
    while ((stream >> std::ws).peek() == '#') {
      stream.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    int number = 0;
    stream >> number;
    require(number >= 1 && number <= highest,
            fmt::format("has no usable {} in its head; allowed: 1 to {}", name, highest));
    return number;
  };
  const bool is_text = bytes.compare(0, 2, "P2") == 0;
  require(
      is_text || bytes.compare(0, 2, "P5") == 0,
      "is not a PGM (it begins with neither P5 nor P2), nor a PNG; convert it, as by ImageMagick: "
      "convert MAP map.png");
  stream.ignore(2);
  map.width = read_number("width", 1 << 20);
  map.height = read_number("height", 1 << 20);
  const int brightest = read_number("brightest value", 65535);
  require(brightest == 255, fmt::format("has the brightest value {}; allowed: 255", brightest));
  if (is_text) {
    read_text_pixels(path, stream, map);
    return;
  }
  stream.ignore();  // the one white space that ends the head
  const std::ptrdiff_t count = std::ptrdiff_t{map.width} * map.height;
  const std::streamsize left = std::max<std::streamsize>(0, stream.rdbuf()->in_avail());
  require(left >= count, fmt::format("is cut off: {} x {} pixels are announced, {} are there",
                                     map.width, map.height, left));
  map.pixels.assign(bytes.end() - left, bytes.end() - left + count);
}

/// The few values of a map's YAML file.
class MapYaml {
 public:
  explicit MapYaml(std::string path) : path_(std::move(path)) {
    const std::string text = read_file(path_);
    try {
      root_ = YAML::Load(text);
    } catch (const YAML::Exception& error) {
      throw FileError(fmt::format("'{}' is not YAML: {}", path_, error.what()));
    }
    if (!root_.IsMap()) {
      throw FileError(fmt::format("'{}' is not the YAML of a map", path_));
    }
  }

  template <typename Value>
  [[nodiscard]] Value get(const char* key) const {
    const YAML::Node node = root_[key];
    if (!node) {
      throw FileError(fmt::format("'{}' has no '{}'", path_, key));
    }
    try {
      return node.as<Value>();
    } catch (const YAML::Exception&) {
      throw FileError(fmt::format("'{}' has a '{}' that cannot be read", path_, key));
    }
  }

  [[nodiscard]] bool has(const char* key) const { return static_cast<bool>(root_[key]); }

  void require(bool condition, const std::string& text) const {
    if (!condition) {
      throw FileError(fmt::format("'{}': {}", path_, text));
    }
  }

 private:
  std::string path_;
  YAML::Node root_;
};

constexpr std::array kModes = {"trinary", "scale", "raw"};

/// How an image in colours, or one of probabilities, is to be read.
struct ImageMeaning {
  std::string mode;
  bool negate = false;
  double occupied_threshold = 0.65;
  double free_threshold = 0.196;

  /// What map_server publishes for a pixel: 0 to 100, or -1.
  [[nodiscard]] int value_of(const std::uint8_t* pixel, int channels) const {
    const bool has_alpha = channels == 4;
    const int averaged = has_alpha && mode != "trinary" ? 3 : channels;
    double sum = 0.0;
    for (int i = 0; i < averaged; ++i) {
      sum += pixel[i];
    }
    const double mean = negate ? 255.0 - sum / averaged : sum / averaged;
    if (mode == "raw") {
      return mean <= 100.0 ? static_cast<int>(mean) : -1;
    }
    const double occupancy = (255.0 - mean) / 255.0;
    if (occupancy > occupied_threshold) {
      return 100;
    }
    if (occupancy < free_threshold) {
      return 0;
    }
    if (mode == "trinary" || (has_alpha && pixel[3] == 0)) {
      return -1;
    }
    const double between =
        (occupancy - free_threshold) / (occupied_threshold - free_threshold);  // nan: they are one
    return std::isfinite(between) ? static_cast<int>(1.0 + 98.0 * between) : -1;
  }

  /// The pixel that stands for that in an image of map_saver.
  [[nodiscard]] std::uint8_t pixel_of(const std::uint8_t* pixel, int channels) const {
    const MapThresholds thresholds;
    const double value = 0.01 * value_of(pixel, channels);
    if (value >= thresholds.occupied) {
      return MapImage::kOccupiedPixel;
    }
    return value >= 0.0 && value <= thresholds.free ? MapImage::kFreePixel
                                                    : MapImage::kUnknownPixel;
  }
};

/// Reads size and pixels of an image whose YAML file was read. A gray image in the usual mode keeps
/// its pixels; of all others states are made.
void read_image(const std::string& path, const std::string& mode, MapImage& map) {
  const std::string bytes = read_file(path);
  PngImage image;
  if (is_png(bytes)) {
    try {
      image = read_png(bytes);
    } catch (const std::exception& error) {
      throw FileError(fmt::format("'{}' {}", path, error.what()));
    }
    map.width = image.width;
    map.height = image.height;
    map.pixels.swap(image.samples);
  } else {
    read_pgm(path, bytes, map);
  }
  if (image.channels == 1 && mode == "trinary") {
    return;
  }
  const ImageMeaning meaning{mode, map.negate, map.occupied_threshold, map.free_threshold};
  const std::size_t count = map.pixels.size() / static_cast<std::size_t>(image.channels);
  const std::uint8_t* sample = map.pixels.data();
  for (std::size_t i = 0; i < count; ++i, sample += image.channels) {
    map.pixels[i] = meaning.pixel_of(sample, image.channels);  // never beyond what is read
  }
  map.pixels.resize(count);
  const MapImage usual;
  map.negate = usual.negate;
  map.occupied_threshold = usual.occupied_threshold;
  map.free_threshold = usual.free_threshold;
}

Pose2 read_origin(const MapYaml& yaml) {
  const auto origin = yaml.get<std::vector<double>>("origin");
  yaml.require(origin.size() == 3, "origin has to be [x, y, yaw]");
  const Pose2 pose{origin[0], origin[1], origin[2]};
  constexpr double kFarthest = 1e8;  // [m], as of start_x
  yaml.require(pose.is_finite(), "origin has to be finite");
  yaml.require(pose.translation().norm() <= kFarthest, "origin has to be within 1e8 m of 0, 0");
  return {pose.x, pose.y, wrap_angle(pose.theta)};
}

}  // namespace

std::vector<FileContents> map_files(const std::string& base_path, const MapImage& map,
                                    MapFormat format) {
  const bool as_png = format == MapFormat::kPng;
  const std::string image_path = base_path + (as_png ? ".occupancy.png" : ".pgm");
  const std::string image_name = std::filesystem::path(image_path).filename().string();
  return {{image_path, as_png ? gray_png(map.width, map.height, map.pixels) : pgm_of(map)},
          {base_path + ".yaml", yaml_of(map, image_name)}};
}

void write_map(const std::string& base_path, const MapImage& map, MapFormat format) {
  replace_files(map_files(base_path, map, format));
}

MapImage read_map(const std::string& yaml_path) {
  const MapYaml yaml(yaml_path);
  const auto mode = yaml.has("mode") ? yaml.get<std::string>("mode") : std::string(kModes[0]);
  yaml.require(std::count(kModes.begin(), kModes.end(), mode) > 0,
               fmt::format("mode '{}' is not allowed; allowed: {}, or leave it out", mode,
                           join({kModes.begin(), kModes.end()})));
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
  read_image((folder / yaml.get<std::string>("image")).string(), mode, map);
  return map;
}

}  // namespace matchbox_slam
