#include "simulation/presets.hpp"

#include <utility>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

struct Setting {
  const char* option;
  ParameterValue value;
};

Parameters values_of(const std::vector<Setting>& settings) {
  Parameters values;
  for (const Setting& setting : settings) {
    values.set(setting.option, setting.value);
  }
  return values;
}

/// The default, of which only this is other.
Parameters field(int beams, double degrees, double range_max, double scan_rate) {
  return values_of({{"beams", std::int64_t{beams}},
                    {"field_of_view", degrees_to_radians(degrees)},
                    {"range_max", range_max},
                    {"scan_rate", scan_rate}});
}

Parameters with(Parameters values, const std::vector<Setting>& settings) {
  values.merge(values_of(settings));
  return values;
}

/// A turning laser's, whose sweep takes all the time from scan to scan.
double sweep(double beams, double scan_rate) { return 1.0 / (beams * scan_rate); }

/// All errors of OdometryOptions.
Parameters errors(double translation_noise, double rotation_noise, double heading_noise,
                  double translation_bias, double rotation_bias, double heading_bias,
                  double translation_wander, double rotation_wander) {
  return values_of({{"translation_noise", translation_noise},
                    {"rotation_noise", rotation_noise},
                    {"heading_noise", heading_noise},
                    {"translation_bias", translation_bias},
                    {"rotation_bias", rotation_bias},
                    {"heading_bias", heading_bias},
                    {"translation_wander", translation_wander},
                    {"rotation_wander", rotation_wander}});
}

}  // namespace

std::vector<Preset> sensor_presets() {
  const Parameters lds01 = with(field(360, 360.0, 3.5, 5.0),
                                {{"range_min", 0.12}, {"time_increment", sweep(360.0, 5.0)}});
  return {
      {"utm30", "Hokuyo UTM-30LX, the default", {}},
      {"sick180", "SICK LMS, 180 beams a degree apart, 80 m, 10 Hz",
       with(field(180, 180.0, 80.0, 10.0), {{"no_return", std::string("over_range")}})},
      {"lds01", "TurtleBot3's, 360 beams all round, 3.5 m, which sweep over the 0.2 s of a turn",
       lds01},
      {"lds01_as_sent",
       "the same with what its driver tells: time_increment 2.99e-5, scan_time 0, and 0 for no "
       "return",
       with(lds01, {{"sent_time_increment", 2.99e-5},
                    {"sent_scan_time", 0.0},
                    {"no_return", std::string("zero")}})},
      {"rplidar_a1", "360 beams all round, 12 m, 5.5 Hz, which sweep, but time_increment is 0",
       with(field(360, 360.0, 12.0, 5.5), {{"range_min", 0.15},
                                           {"time_increment", sweep(360.0, 5.5)},
                                           {"sent_time_increment", 0.0},
                                           {"sent_scan_time", 0.0}})},
      {"narrow120", "360 beams over 120 degrees, 10 m, 10 Hz", field(360, 120.0, 10.0, 10.0)},
      {"narrow90", "270 beams over 90 degrees, 10 m, 10 Hz", field(270, 90.0, 10.0, 10.0)},
      // Khoshelham and Elberink, "Accuracy and Resolution of Kinect Depth Data", Sensors 2012: the
      // deviation is 1.4 mm at 1 m.
      {"depth_camera",
       "320 beams over 1 rad, 0.45 to 5 m, 10 Hz, noise by the square of the range, and NaN beyond",
       with(field(320, 0.0, 5.0, 10.0), {{"field_of_view", 1.0},
                                         {"range_min", 0.45},
                                         {"range_noise", 0.0},
                                         {"range_noise_square", 1.4e-3},
                                         {"no_return", std::string("nan")}})},
      {"ranger32", "32 beams all round, 4 m, 10 Hz", field(32, 360.0, 4.0, 10.0)},
      {"in_parts", "360 beams all round, 10 m, 10 turns a second, each sent as ten scans of 36",
       with(field(360, 360.0, 10.0, 10.0),
            {{"time_increment", sweep(360.0, 10.0)}, {"parts", std::int64_t{10}}})},
  };
}

std::vector<Preset> odometry_presets() {
  return {
      {"perfect", "no errors", errors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)},
      {"good", "a decent wheeled robot's, the default", {}},
      {"bad", "off by some 6 % of the way", errors(0.05, 0.06, 0.02, 0.03, 0.03, 0.01, 0.05, 0.04)},
      {"awful", "off by some 20 % of each metre and 0.08 rad of each radian, as in old logs",
       errors(0.05, 0.08, 0.05, 0.06, 0.05, 0.02, 0.2, 0.08)},
      {kNoOdometry, "left out of the bag: map it with --no-odom", {}},
  };
}

Preset preset_named(const std::vector<Preset>& presets, const std::string& flag,
                    const std::string& name) {
  std::vector<std::string> names;
  for (const Preset& preset : presets) {
    if (preset.name == name) {
      return preset;
    }
    names.push_back(preset.name);
  }
  throw ConfigurationError(flag + ": '" + name +
                           "' is not allowed; allowed: " + one_of(names).text());
}

std::string preset_help(const std::vector<Preset>& presets) {
  std::string help;
  for (const Preset& preset : presets) {
    help += (help.empty() ? "" : "; ") + preset.name + ": " + preset.meaning;
  }
  return help;
}

}  // namespace matchbox_slam
