#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bag/bag_file.hpp"
#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

struct Written {
  std::string topic;
  std::string text;
  ros::Time time;
};

/// Said in whole seconds up to `spread` around ever later times, many of them at once, in chunks of
/// a few messages.
std::vector<Written> write_bag(const std::string& path, std::uint64_t seed, double spread) {
  Random random(seed);
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  bag.setChunkThreshold(400);
  std::vector<Written> all;
  for (int i = 0; i < 200; ++i) {
    Written said;
    said.topic = "/topic" + std::to_string(i % 3);
    said.text = "message " + std::to_string(i);
    said.time.sec = static_cast<std::uint32_t>(100.0 + 0.1 * i + spread * random.uniform());
    std_msgs::String message;
    message.data = said.text;
    bag.write(said.topic, said.time, message);
    all.push_back(said);
  }
  return all;
}

/// By the oracle: all of it sorted.
std::vector<std::string> texts_of(std::vector<Written> all, const std::string& topic,
                                  const BagSelection& selection) {
  std::stable_sort(all.begin(), all.end(),
                   [](const Written& a, const Written& b) { return a.time < b.time; });
  std::vector<std::string> texts;
  for (const Written& said : all) {
    if ((topic.empty() || said.topic == topic) && said.time >= selection.first &&
        said.time <= selection.last) {
      texts.push_back(said.text);
    }
  }
  return texts;
}

/// @param topic  empty: all.
std::vector<std::string> read(const BagFile& bag, const std::string& topic,
                              BagSelection selection) {
  for (const auto& [number, connection] : bag.connections()) {
    if (topic.empty() || connection.topic == topic) {
      selection.connections.insert(number);
    }
  }
  BagEntries entries(bag, std::move(selection));
  BagMessageReader reader(bag);
  std::vector<std::string> texts;
  for (const BagEntry* entry = entries.peek(); entry != nullptr; entry = entries.peek()) {
    texts.push_back(reader.read(*entry).array().text());
    entries.pop();
  }
  return texts;
}

TEST(BagFile, EntriesComeInTheOrderOfTimeHoweverTheyWereRecorded) {
  const TemporaryFolder folder;
  const std::string path = folder / "said.bag";
  for (const double spread : {0.0, 2.0, 30.0}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const std::vector<Written> all = write_bag(path, seed, spread);
      const BagFile bag(path);
      EXPECT_GT(bag.chunks().size(), 10U);
      BagSelection some;
      some.first.sec = 107;
      some.last.sec = 119;
      for (const BagSelection& selection : {BagSelection{}, some}) {
        for (const std::string topic : {"", "/topic1"}) {
          EXPECT_EQ(read(bag, topic, selection), texts_of(all, topic, selection))
              << spread << " " << seed << " " << topic;
        }
      }
    }
  }
}

TEST(BagFile, AChunkThatIsReadAgainIsUnpackedOnce) {
  const TemporaryFolder folder;
  const std::string path = folder / "said.bag";
  write_bag(path, 1, 0.0);
  const BagFile bag(path);
  BagRecordReader records(path);
  const std::uint64_t first = bag.chunks().front().position;
  const std::uint64_t last = bag.chunks().back().position;
  const auto before = bag.unpacked(first, records);
  EXPECT_NE(*bag.unpacked(last, records), *before);
  EXPECT_EQ(bag.unpacked(first, records), before);
}

TEST(BagFile, ManyThatAreOpenKeepNoMoreThanOne) {
  constexpr std::size_t kMegabyte = std::size_t{1} << 20U;
  const TemporaryFolder folder;
  std::vector<std::unique_ptr<BagFile>> bags;
  std::vector<std::weak_ptr<const BagFile::Bytes>> chunks;
  for (int i = 0; i < 12; ++i) {
    const std::string path = folder / (std::to_string(i) + ".bag");
    std_msgs::String message;
    message.data = std::string(kMegabyte, static_cast<char>('a' + i));
    rosbag::Bag(path, rosbag::bagmode::Write).write("/said", ros::Time(100.0), message);
    bags.push_back(std::make_unique<BagFile>(path));
    BagRecordReader records(path);
    const auto chunk = bags.back()->unpacked(bags.back()->chunks().front().position, records);
    EXPECT_EQ(chunk->back(), 'a' + i) << "its own, though all are at one position";
    chunks.push_back(chunk);
  }
  const auto kept = std::count_if(chunks.begin(), chunks.end(),
                                  [](const auto& chunk) { return !chunk.expired(); });
  EXPECT_EQ(kept, 3) << "of 1 MB and some bytes each, in 4 MB";
}

TEST(BagFile, OfNoConnectionNothingComes) {
  const TemporaryFolder folder;
  const std::string path = folder / "said.bag";
  write_bag(path, 1, 0.0);
  const BagFile bag(path);
  EXPECT_EQ(BagEntries(bag, {}).peek(), nullptr);
}

TEST(BagFile, ThatIsGoneCannotBeOpened) {
  const TemporaryFolder folder;
  const std::string path = folder / "said.bag";
  write_bag(path, 1, 0.0);
  const BagFile bag(path);
  std::filesystem::remove(path);
  EXPECT_EQ(error_text<BagError>([&] { const BagMessageReader reader(bag); }),
            "bag '" + path + "' cannot be opened: No such file or directory");
}

TEST(BagFile, TellsWhatIsInIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "said.bag";
  const std::vector<Written> all = write_bag(path, 1, 30.0);
  const BagFile bag(path);
  const auto by_time = [](const Written& a, const Written& b) { return a.time < b.time; };
  EXPECT_EQ(bag.begin_time(), std::min_element(all.begin(), all.end(), by_time)->time);
  EXPECT_EQ(bag.end_time(), std::max_element(all.begin(), all.end(), by_time)->time);
  ASSERT_EQ(bag.connections().size(), 3U);
  for (const auto& [number, connection] : bag.connections()) {
    EXPECT_EQ(connection.messages, texts_of(all, connection.topic, {}).size());
  }
}

TEST(BagFile, AnIndexThatHasChangedSinceIsToldOf) {
  const TemporaryFolder folder;
  const std::string path = folder / "said.bag";
  write_bag(path, 1, 0.0);
  const BagFile bag(path);
  { rosbag::Bag other(path, rosbag::bagmode::Write); }
  EXPECT_THROW(read(bag, "", {}), BagError);
}

}  // namespace
}  // namespace matchbox_slam
