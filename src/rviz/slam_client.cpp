#include "rviz/slam_client.hpp"

#include <dynamic_reconfigure/Reconfigure.h>
#include <fmt/core.h>
#include <ros/names.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "matchbox_slam/LoadMap.h"
#include "matchbox_slam/SetPoseAtStamp.h"
#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

using visualization_msgs::Marker;

double seconds_since(const std::chrono::steady_clock::time_point& then) {
  return then == std::chrono::steady_clock::time_point()
             ? kInfinity
             : std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

/// The answer of a service that tells in words what became of it.
template <typename Response>
std::string answer_of(const Response& response) {
  if (response.success == 0) {
    throw std::runtime_error(response.message);
  }
  return response.message;
}

std::string text_value(const dynamic_reconfigure::Config& config, const std::string& name) {
  for (const auto& entry : config.strs) {
    if (entry.name == name) {
      return entry.value;
    }
  }
  return "";
}

/// An arrow for a place, and its rank beside it; the best is opaque.
geometry_msgs::Pose pose_of(const Place& place) {
  geometry_msgs::Pose pose;
  pose.position.x = place.x;
  pose.position.y = place.y;
  pose.orientation.z = std::sin(0.5 * place.theta);
  pose.orientation.w = std::cos(0.5 * place.theta);
  return pose;
}

Place place_of(const geometry_msgs::Pose& pose, double score) {
  const double theta = wrap_angle(2.0 * std::atan2(pose.orientation.z, pose.orientation.w));
  return {pose.position.x, pose.position.y, theta, score};
}

std::vector<Marker> markers_of(const Place& place, std::size_t rank, const std::string& frame) {
  Marker arrow;
  arrow.header.frame_id = frame;
  arrow.ns = "places";
  arrow.id = static_cast<int>(rank);
  arrow.type = Marker::ARROW;
  arrow.pose = pose_of(place);
  arrow.pose.position.z = 0.1;
  arrow.scale.x = 1.4;
  arrow.scale.y = 0.25;
  arrow.scale.z = 0.1;
  arrow.color.r = 0.9F;
  arrow.color.g = 0.2F;
  arrow.color.b = 0.8F;
  arrow.color.a = rank == 1 ? 1.0F : 0.6F;
  Marker text = arrow;
  text.ns = "ranks";
  text.type = Marker::TEXT_VIEW_FACING;
  text.text = std::to_string(rank);
  text.scale.z = 0.8;
  text.pose.position.x -= 0.5 * std::cos(place.theta);
  text.pose.position.y -= 0.5 * std::sin(place.theta);
  text.pose.position.z = 0.3;
  text.color.a = 1.0F;
  return {arrow, text};
}

}  // namespace

SlamClient::SlamClient(const std::string& node)
    : node_(ros::names::resolve(node)), spinner_(1, &callbacks_) {
  view_.node = node_;
  handle_.setCallbackQueue(&callbacks_);
  places_ = handle_.advertise<visualization_msgs::MarkerArray>(node_ + "/places", 1, true);
  const std::string space = ros::names::parentNamespace(node_);
  subscribers_ = {
      handle_.subscribe(ros::names::append(space, "match_info"), 10, &SlamClient::on_match, this),
      handle_.subscribe(ros::names::append(space, "likely_poses"), 10, &SlamClient::on_likely,
                        this),
      handle_.subscribe("/diagnostics", 100, &SlamClient::on_diagnostics, this),
      handle_.subscribe(node_ + "/parameter_descriptions", 1, &SlamClient::on_descriptions, this),
      handle_.subscribe(node_ + "/parameter_updates", 1, &SlamClient::on_parameters, this)};
  spinner_.start();
  thread_ = std::thread([this] { run(); });
}

SlamClient::~SlamClient() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_ending_ = true;
    called_.shutdown();  // whoever waits for an answer gets none
  }
  asked_.notify_all();
  thread_.join();
  spinner_.stop();
  for (ros::Subscriber& subscriber : subscribers_) {
    subscriber.shutdown();
  }
}

SlamView SlamClient::view() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  SlamView view = view_;
  view.report.match_age = seconds_since(match_time_);
  view.report.loop_age = seconds_since(loop_time_);
  view.report.diagnostics_age = seconds_since(diagnostics_time_);
  return view;
}

// --- what the node tells ---

void SlamClient::on_match(const MatchInfo& match) {
  const std::lock_guard<std::mutex> lock(mutex_);
  match_time_ = Clock::now();
  loop_time_ = match.closed_loop != 0 ? match_time_ : loop_time_;
  map_frame_ = match.header.frame_id;
  view_.report.state = match.state;
  view_.report.score = match.score;
  view_.report.evidence = match.evidence;
}

void SlamClient::on_likely(const LikelyPoses& likely) {
  std::vector<Place> hypotheses;
  for (std::size_t i = 0; i < std::min(likely.poses.size(), likely.weights.size()); ++i) {
    hypotheses.push_back(place_of(likely.poses[i], likely.weights[i]));
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  view_.report.hypotheses = std::move(hypotheses);
  view_.report.elsewhere = likely.elsewhere;
}

void SlamClient::on_diagnostics(const diagnostic_msgs::DiagnosticArray& array) {
  for (const diagnostic_msgs::DiagnosticStatus& status : array.status) {
    if ("/" + status.name != node_ + ": SLAM") {
      continue;
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    diagnostics_time_ = Clock::now();
    view_.report.level = static_cast<std::uint8_t>(status.level);
    view_.report.message = status.message;
    view_.report.values.clear();
    for (const diagnostic_msgs::KeyValue& value : status.values) {
      view_.report.values[value.key] = value.value;
    }
  }
}

void SlamClient::on_descriptions(const dynamic_reconfigure::ConfigDescription& descriptions) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const dynamic_reconfigure::Group& group : descriptions.groups) {
    for (const dynamic_reconfigure::ParamDescription& parameter : group.parameters) {
      if (parameter.name == "matcher") {
        view_.matchers = words_of(parameter.edit_method);
      }
    }
  }
}

void SlamClient::on_parameters(const dynamic_reconfigure::Config& parameters) {
  const std::lock_guard<std::mutex> lock(mutex_);
  view_.matcher = text_value(parameters, "matcher");
  view_.map_file = text_value(parameters, "map_file");
}

// --- what is asked of it ---

void SlamClient::ask(const std::string& doing, Question question) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    questions_.emplace_back(doing, std::move(question));
    view_.doing = questions_.front().first;
  }
  asked_.notify_all();
}

void SlamClient::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    asked_.wait(lock, [this] { return is_ending_ || !questions_.empty(); });
    if (is_ending_) {
      return;
    }
    view_.doing = questions_.front().first;
    const Question question = questions_.front().second;
    lock.unlock();
    std::string answer;
    bool succeeded = true;
    try {
      answer = question();
    } catch (const std::exception& error) {
      answer = error.what();
      succeeded = false;
    }
    lock.lock();
    questions_.pop_front();
    view_.doing.clear();
    view_.answer = answer;
    view_.succeeded = succeeded;
    ++view_.answers;
  }
}

/// Throws when there is no answer, saying why.
template <typename Service>
void SlamClient::call(const std::string& name, Service& service) {
  const std::string full_name = fmt::format("{}/{}", node_, name);
  // A persistent one can be shut down while it waits.
  ros::ServiceClient client = ros::NodeHandle().serviceClient<Service>(full_name, true);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_ending_) {
      throw std::runtime_error("given up");
    }
    called_ = client;
  }
  const bool is_there = client.isValid();
  const bool has_answered = is_there && client.call(service);
  const std::lock_guard<std::mutex> lock(mutex_);
  called_ = ros::ServiceClient();
  if (!is_there) {
    throw std::runtime_error(fmt::format("nobody offers {}: is the node running?", full_name));
  }
  if (!has_answered) {
    throw std::runtime_error(full_name +
                             " gave no answer: the node has ended, or is of another version");
  }
}

void SlamClient::set_parameter(const std::string& name, const std::string& value) {
  dynamic_reconfigure::Reconfigure service;
  service.request.config.strs.resize(1);
  service.request.config.strs[0].name = name;
  service.request.config.strs[0].value = value;
  call("set_parameters", service);
  if (text_value(service.response.config, name) != value) {
    throw std::runtime_error(
        fmt::format("{} '{}' was refused; the node's log says why", name, value));
  }
}

void SlamClient::choose_matcher(const std::string& matcher) {
  ask("Choosing " + matcher, [this, matcher] {
    set_parameter("matcher", matcher);
    return fmt::format("it goes on with {}, map and pose kept", matcher);
  });
}

void SlamClient::save_map(const std::string& file) {
  ask("Saving", [this, file] {
    if (!file.empty()) {
      set_parameter("map_file", without_map_extension(file));
    }
    std_srvs::Trigger service;
    call("save_map", service);
    return answer_of(service.response);
  });
}

void SlamClient::load_map(const std::string& file) {
  ask("Loading", [this, file] {
    if (file.empty()) {
      throw std::runtime_error(
          "which map? Write its file into the field above: a .slam file of Save, or a .yaml file "
          "as of map_server");
    }
    LoadMap service;
    service.request.path = file_to_load(file);
    call("load_map", service);
    forget_places();
    return answer_of(service.response);
  });
}

void SlamClient::set_paused(bool paused) {
  ask(paused ? "Pausing" : "Resuming", [this, paused] {
    std_srvs::SetBool service;
    service.request.data = static_cast<std::uint8_t>(paused);
    call("pause", service);
    std::string answer = answer_of(service.response);
    const std::lock_guard<std::mutex> lock(mutex_);
    view_.report.values["Paused"] = paused ? "yes" : "no";  // as it will tell within a second
    return answer;
  });
}

void SlamClient::reset() {
  ask("Resetting", [this] {
    std_srvs::Trigger service;
    call("reset", service);
    forget_places();
    return answer_of(service.response);
  });
}

void SlamClient::relocalise() {
  ask("Relocalising", [this] {
    Relocalise service;
    call("relocalise", service);
    show_places(service.response);
    if (service.response.poses.empty()) {
      throw std::runtime_error(service.response.message);
    }
    return service.response.message + "; click the one where the robot is";
  });
}

void SlamClient::choose_place(std::size_t index) {
  ask("Taking a place", [this, index] {
    SetPoseAtStamp service;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (index >= view_.places.size()) {
        throw std::runtime_error("that place is no more among them; Relocalise again");
      }
      service.request.stamp = places_stamp_;
      service.request.pose = pose_of(view_.places[index]);
    }
    call("set_pose_at_stamp", service);
    const std::string answer = answer_of(service.response);
    forget_places();
    return fmt::format("place {} is taken: {}", index + 1, answer);
  });
}

// --- places ---

void SlamClient::show_places(const Relocalise::Response& found) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    places_stamp_ = found.stamp;
    view_.places.clear();
    for (std::size_t k = 0; k < std::min(found.poses.size(), found.scores.size()); ++k) {
      view_.places.push_back(place_of(found.poses[k], found.scores[k]));
    }
  }
  publish_places();
}

void SlamClient::forget_places() { show_places({}); }

void SlamClient::publish_places() const {
  visualization_msgs::MarkerArray message;
  message.markers.resize(1);
  message.markers.front().action = Marker::DELETEALL;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    message.markers.front().header.frame_id = map_frame_;
    for (std::size_t k = 0; k < view_.places.size(); ++k) {
      for (Marker& marker : markers_of(view_.places[k], k + 1, map_frame_)) {
        message.markers.push_back(std::move(marker));
      }
    }
  }
  places_.publish(message);
}

}  // namespace matchbox_slam
