// Of rviz/slam_panel.hpp: the panel of rviz, loaded as rviz does, without a window of rviz around
// it: its buttons are clicked, and the node does what they say. QT_QPA_PLATFORM=offscreen needs no
// display.

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <rviz/config.h>
#include <rviz/panel.h>
#include <std_srvs/Trigger.h>
#include <visualization_msgs/MarkerArray.h>

#include <QApplication>
#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QPushButton>
#include <QSignalSpy>
#include <QTest>
#include <cmath>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <pluginlib/class_loader.hpp>
#include <string>

#include "bag/simulated_bag.hpp"
#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/LikelyPoses.h"
#include "matchbox_slam/MatchInfo.h"
#include "matchbox_slam/io/saved_map.hpp"
#include "node/bag_player.hpp"
#include "node/slam_node.hpp"
#include "ros/message_conversion.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

/// Handles what happens to widgets until it is so, or until it should long have been.
bool becomes_so(const std::function<bool()>& is_so) { return QTest::qWaitFor(is_so, 60000); }

/// The panel and what is in it.
class Panel {
 public:
  Panel() : widget_(loader().createUnmanagedInstance("matchbox_slam/SlamPanel")) {
    widget_->show();
  }

  [[nodiscard]] rviz::Panel& widget() { return *widget_; }

  template <typename Part>
  [[nodiscard]] Part& part(const char* name) {
    auto* const part = widget_->findChild<Part*>(name);
    if (part == nullptr) {
      throw std::logic_error(std::string("the panel has no part ") + name);
    }
    return *part;
  }

  [[nodiscard]] std::string text(const char* label) {
    return part<QLabel>(label).text().toStdString();
  }

  [[nodiscard]] std::string button(const char* name) {
    return part<QPushButton>(name).text().toStdString();
  }

  /// Waits for what was asked for before.
  void click(const char* button) {
    auto& it = part<QPushButton>(button);
    EXPECT_TRUE(becomes_so([&] { return it.isEnabled(); })) << button;
    QTest::mouseClick(&it, Qt::LeftButton);
  }

  void write(const char* field, const std::string& text) {
    auto& line = part<QLineEdit>(field);
    line.selectAll();
    QTest::keyClick(&line, Qt::Key_Delete);
    QTest::keyClicks(&line, QString::fromStdString(text));
    QTest::keyClick(&line, Qt::Key_Return);
  }

  [[nodiscard]] bool comes_to_say(const char* label, const std::string& words) {
    return becomes_so([&] { return contains(text(label), words); });
  }

 private:
  static pluginlib::ClassLoader<rviz::Panel>& loader() {
    // Kept to the end: when it goes, what it needs may be gone.
    static auto* const kLoader = new pluginlib::ClassLoader<rviz::Panel>("rviz", "rviz::Panel");
    return *kLoader;
  }

  const std::unique_ptr<rviz::Panel> widget_;
};

/// A node, a robot that drives through its world, and the panel.
class SlamPanel : public testing::Test {
 protected:
  SlamPanel() {
    const World world = make_world("rooms", 4);
    SimulationOptions options;
    options.time.duration = 20.0;
    const SimulatedRun run = simulate_run(world, world.route(), options, 4);
    SimulatedBagWriter(folder_ / "run.bag", {}).write(run, {"rooms", 4, options.laser, {}});
    for (std::size_t k = 0; k < run.scans.size(); ++k) {
      truth_[ros::Time(run.scans[k].stamp)] =
          run.world_from_base.front().inverse() * run.world_from_base[k];
    }
    ros::param::set("/mapper/base_frame", "base_footprint");
    ros::param::set("/mapper/odom_frame", "odom_combined");
    ros::param::set("/mapper/map_file", folder_ / "map");
    spinner_.start();
    player_ = std::make_unique<Player>(folder_ / "run.bag");
    slam_ = std::make_unique<SlamNode>(ros::NodeHandle(), ros::NodeHandle("/mapper"));
    panel_.write("node", "/mapper");
    EXPECT_TRUE(
        wait_until_so([&] { return player_->is_heard() && matches_.getNumPublishers() > 0; }));
    EXPECT_TRUE(drive(40));
    EXPECT_TRUE(panel_.comes_to_say("figures", " key scan"));
  }

  ~SlamPanel() override { ros::param::del("/mapper"); }

  /// Drives until so many more scans have come back as poses, and as matches.
  bool drive(int scans) {
    const int wanted = matches_heard() + scans;
    return player_->drive(scans) && wait_until_so([&] { return matches_heard() >= wanted; });
  }

  [[nodiscard]] MatchInfo match() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return match_;
  }

  /// Maps that were begun.
  [[nodiscard]] int maps_begun() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return begun_;
  }

  /// How far the newest pose is from the truth [m].
  [[nodiscard]] double error() {
    const MatchInfo newest = match();
    const Pose2& truth = truth_.at(newest.header.stamp);
    return std::hypot(newest.pose.x - truth.x, newest.pose.y - truth.y);
  }

  /// As 2D Pose Estimate does.
  void tell_pose(const Pose2& map_from_base) {
    ros::NodeHandle node;
    ros::Publisher told =
        node.advertise<geometry_msgs::PoseWithCovarianceStamped>("/initialpose", 1);
    ASSERT_TRUE(wait_until_so([&] { return told.getNumSubscribers() > 0; }));
    geometry_msgs::PoseWithCovarianceStamped message;
    message.header.frame_id = "map";
    message.pose.pose = to_pose_message(map_from_base);
    told.publish(message);
    ASSERT_TRUE(wait_until_so(
        [&] { return (believed().translation() - map_from_base.translation()).norm() < 0.01; }));
  }

  /// Where the node takes the robot to be.
  Pose2 believed() {
    std_srvs::Trigger save;
    EXPECT_TRUE(ros::service::call("/mapper/save_map", save));
    return read_saved_map(folder_ / "map.slam").motion.fixed_from_base;
  }

  [[nodiscard]] Pose2 true_pose() { return truth_.at(match().header.stamp); }

  /// Clicks a line of the list of places.
  void click_place(int row) {
    auto& places = panel_.part<QListWidget>("places");
    ASSERT_TRUE(becomes_so([&] { return places.count() > row && places.isEnabled(); }));
    QTest::mouseClick(places.viewport(), Qt::LeftButton, Qt::NoModifier,
                      places.visualItemRect(places.item(row)).center());
  }

  const TemporaryFolder folder_;
  Panel panel_;
  std::unique_ptr<Player> player_;
  std::unique_ptr<SlamNode> slam_;

 private:
  int matches_heard() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return heard_;
  }

  void on_match(const MatchInfo& match) {
    const std::lock_guard<std::mutex> lock(mutex_);
    match_ = match;
    ++heard_;
    begun_ += match.status == "rejected_no_reference" ? 1 : 0;
  }

  std::map<ros::Time, Pose2> truth_;  ///< of the base in the map
  std::mutex mutex_;
  MatchInfo match_;
  int heard_ = 0;
  int begun_ = 0;
  ros::NodeHandle node_;
  ros::Subscriber matches_ = node_.subscribe("match_info", 1000, &SlamPanel::on_match, this);
  ros::AsyncSpinner spinner_{2};
};

TEST_F(SlamPanel, ShowsHowItGoes) {
  EXPECT_TRUE(panel_.comes_to_say("state", "Tracking"));
  EXPECT_TRUE(contains(panel_.text("figures"), "Score 0."));
  EXPECT_TRUE(contains(panel_.text("figures"), "0 loops closed"));
  EXPECT_EQ(panel_.text("hypotheses"), "");
  ros::NodeHandle node;
  const ros::Publisher likely = node.advertise<LikelyPoses>("likely_poses", 1);
  ASSERT_TRUE(wait_until_so([&] { return likely.getNumSubscribers() > 0; }));
  ASSERT_TRUE(drive(1));
  LikelyPoses message;
  message.poses.resize(2);
  message.poses.back().position.x = 3.0;
  message.weights = {0.7, 0.2};
  message.elsewhere = 0.1;
  EXPECT_TRUE(becomes_so([&] {
    likely.publish(message);  // again and again: what the node says of its last scan may come after
    return contains(panel_.text("hypotheses"), "\n20 % at x 3.00 m,  y 0.00 m,  ");
  })) << panel_.text("hypotheses");
  slam_.reset();
  EXPECT_TRUE(panel_.comes_to_say("state", "No node"));
  EXPECT_TRUE(contains(panel_.text("advice"), "/mapper"));
}

TEST_F(SlamPanel, SavesWhereItIsTold) {
  panel_.click("save");
  ASSERT_TRUE(panel_.comes_to_say("answer", "saved as " + folder_ / "map.pgm"))
      << panel_.text("answer");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "map.slam"));
  panel_.write("file", folder_ / "other.slam");
  panel_.click("save");
  ASSERT_TRUE(panel_.comes_to_say("answer", "saved as " + folder_ / "other.pgm"))
      << panel_.text("answer");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "other.slam"));
}

TEST_F(SlamPanel, PausesAndResumes) {
  EXPECT_EQ(panel_.button("pause"), "Pause");
  panel_.click("pause");
  ASSERT_TRUE(becomes_so([&] { return panel_.button("pause") == "Resume"; }));
  EXPECT_TRUE(panel_.comes_to_say("state", "Paused"));
  const int before = player_->heard();
  player_->play(10);
  QTest::qWait(500);
  EXPECT_LT(player_->heard(), before + 2) << "scans are used while it is paused";
  panel_.click("pause");
  ASSERT_TRUE(becomes_so([&] { return panel_.button("pause") == "Pause"; }));
  EXPECT_TRUE(drive(5));
}

TEST_F(SlamPanel, ChangesTheMatcher) {
  auto& matcher = panel_.part<QComboBox>("matcher");
  ASSERT_TRUE(becomes_so([&] { return matcher.count() >= 4 && matcher.isEnabled(); }));
  EXPECT_EQ(matcher.currentText(), "olson");
  const int hough = matcher.findText("hough");  // among those of other packages, too
  ASSERT_GE(hough, 0);
  matcher.setCurrentIndex(hough);
  Q_EMIT matcher.activated(hough);
  ASSERT_TRUE(panel_.comes_to_say("answer", "it goes on with hough")) << panel_.text("answer");
  ASSERT_TRUE(drive(1));
  EXPECT_EQ(match().matcher, "matchbox_slam/Hough");
  EXPECT_EQ(matcher.currentText(), "hough");
}

TEST_F(SlamPanel, ResetsAtTheSecondClick) {
  panel_.click("reset");
  EXPECT_EQ(panel_.button("reset"), "Forget the map?");
  ASSERT_TRUE(becomes_so([&] { return panel_.button("reset") == "Reset"; })) << "for a while";
  ASSERT_TRUE(drive(1));
  EXPECT_EQ(maps_begun(), 1);
  panel_.click("reset");
  panel_.click("reset");
  ASSERT_TRUE(panel_.comes_to_say("answer", "are forgotten")) << panel_.text("answer");
  EXPECT_TRUE(panel_.comes_to_say("figures", "\n0 key scans"));
  ASSERT_TRUE(drive(1));
  EXPECT_TRUE(wait_until_so([&] { return maps_begun() == 2; }));
}

TEST_F(SlamPanel, GoesOnWithASavedMap) {
  panel_.click("load");
  ASSERT_TRUE(panel_.comes_to_say("answer", "which map?"));
  panel_.write("file", folder_ / "nowhere");
  panel_.click("load");
  ASSERT_TRUE(panel_.comes_to_say("answer", "cannot read '" + folder_ / "nowhere.slam'"))
      << panel_.text("answer");
  panel_.write("file", folder_ / "kept");
  panel_.click("save");
  ASSERT_TRUE(panel_.comes_to_say("answer", "saved as"));
  std_srvs::Trigger reset;
  ASSERT_TRUE(ros::service::call("/mapper/reset", reset));
  panel_.click("load");
  ASSERT_TRUE(panel_.comes_to_say("answer", "going on with '" + folder_ / "kept.slam'"))
      << panel_.text("answer");
  ASSERT_TRUE(drive(5));
  EXPECT_EQ(maps_begun(), 1);
  EXPECT_LT(error(), 0.05);
}

TEST_F(SlamPanel, TakesAPlaceOfTheList) {
  tell_pose(true_pose() * Pose2{1.5, 1.0, 2.0});
  panel_.click("relocalise");
  click_place(0);
  ASSERT_TRUE(panel_.comes_to_say("answer", "place 1 is taken")) << panel_.text("answer");
  EXPECT_LT((believed().translation() - true_pose().translation()).norm(), 0.05);
  EXPECT_TRUE(becomes_so([&] { return panel_.part<QListWidget>("places").count() == 0; }));
  ASSERT_TRUE(drive(5));
  EXPECT_LT(error(), 0.05);
}

TEST_F(SlamPanel, APlaceIsThatOfTheScanEvenIfTheRobotHasMovedSince) {
  panel_.click("relocalise");
  ASSERT_TRUE(panel_.comes_to_say("answer", "click the one")) << panel_.text("answer");
  const Pose2 then = true_pose();
  ASSERT_TRUE(drive(40));
  ASSERT_GT((true_pose().translation() - then.translation()).norm(), 0.5);
  click_place(0);
  ASSERT_TRUE(panel_.comes_to_say("answer", "place 1 is taken")) << panel_.text("answer");
  EXPECT_LT((believed().translation() - true_pose().translation()).norm(), 0.05);
  ASSERT_TRUE(drive(5));
  EXPECT_LT(error(), 0.05);
}

TEST_F(SlamPanel, DrawsThePlaces) {
  visualization_msgs::MarkerArray drawn;
  std::mutex mutex;
  ros::NodeHandle node;
  const auto draw = [&](const visualization_msgs::MarkerArray::ConstPtr& markers) {
    const std::lock_guard<std::mutex> lock(mutex);
    drawn = *markers;
  };
  const ros::Subscriber markers = node.subscribe<visualization_msgs::MarkerArray>(
      "/mapper/places", 10,
      boost::function<void(const visualization_msgs::MarkerArray::ConstPtr&)>(draw));
  panel_.click("relocalise");
  ASSERT_TRUE(becomes_so([&] {
    const std::lock_guard<std::mutex> lock(mutex);
    return drawn.markers.size() > 2;
  }));
  EXPECT_EQ(drawn.markers[0].action, visualization_msgs::Marker::DELETEALL);
  EXPECT_EQ(drawn.markers[1].header.frame_id, "map");
  EXPECT_NEAR(drawn.markers[1].pose.position.x, match().pose.x, 0.05);
  EXPECT_NEAR(drawn.markers[1].pose.position.y, match().pose.y, 0.05);
  EXPECT_EQ(drawn.markers[2].text, "1");
}

// --- without a robot ---

TEST(SlamPanelAlone, SaysThatThereIsNoNode) {
  Panel panel;
  panel.write("node", "/nobody");
  EXPECT_TRUE(panel.comes_to_say("state", "No node"));
  EXPECT_TRUE(contains(panel.text("advice"), "/nobody"));
  for (const char* button : {"save", "pause", "relocalise"}) {
    panel.click(button);
    EXPECT_TRUE(panel.comes_to_say("answer", "nobody offers /nobody/")) << panel.text("answer");
  }
  panel.write("node", "my node");
  EXPECT_TRUE(panel.comes_to_say("answer", "my node")) << panel.text("answer");
  panel.click("save");
}

TEST(SlamPanelAlone, RemembersTheNodeInTheConfiguration) {
  rviz::Config config;
  {
    Panel panel;
    const QSignalSpy changes(&panel.widget(), SIGNAL(configChanged()));
    panel.write("node", "/robot/mapper");
    EXPECT_EQ(changes.count(), 1) << "rviz asks whether to save it";
    panel.widget().save(config);
  }
  Panel another;
  EXPECT_EQ(another.part<QLineEdit>("node").text(), "/slam");
  another.widget().load(config);
  EXPECT_EQ(another.part<QLineEdit>("node").text(), "/robot/mapper");
  EXPECT_TRUE(contains(another.text("advice"), "/robot/mapper")) << another.text("advice");
}

TEST(SlamPanelAlone, DoesNotWaitForANodeThatHangs) {
  std::promise<void> release;
  const std::shared_future<void> released = release.get_future().share();
  std::promise<void> asked;
  const boost::function<bool(std_srvs::Trigger::Request&, std_srvs::Trigger::Response&)> hang =
      [&](std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& /*response*/) {
        asked.set_value();
        released.wait();
        return true;
      };
  ros::NodeHandle node("/hanging");
  const ros::ServiceServer server = node.advertiseService("save_map", hang);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  {
    Panel panel;
    panel.write("node", "/hanging");
    panel.click("save");
    asked.get_future().wait();
    EXPECT_TRUE(panel.comes_to_say("answer", "Saving ..."));
    EXPECT_FALSE(panel.part<QPushButton>("save").isEnabled());
    EXPECT_TRUE(panel.comes_to_say("state", "No node")) << "it goes on showing";
  }  // nor does the panel wait when it is closed
  EXPECT_TRUE(ros::ok()) << "the end of ROS ends all waiting";
  release.set_value();
}

}  // namespace
}  // namespace matchbox_slam

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "test_slam_panel");
  QApplication application(argc, argv);
  const ros::NodeHandle keeps_ros_alive;
  return RUN_ALL_TESTS();
}
