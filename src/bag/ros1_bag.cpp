#include "bag/ros1_bag.hpp"

#include <optional>
#include <utility>

#include "bag/ros1_message.hpp"

namespace matchbox_slam {
namespace {

class Ros1Messages : public RecordedMessages {
 public:
  Ros1Messages(const BagFile& bag, BagSelection selection)
      : bag_(bag), entries_(bag, std::move(selection)) {}

  std::optional<ros::Time> peek() override {
    const BagEntry* entry = entries_.peek();
    return entry != nullptr ? std::optional(entry->time) : std::nullopt;
  }

  RecordedMessage next() override {
    if (!reader_) {
      reader_.emplace(bag_);  // only now, as a drive may be split into many bags
    }
    const BagEntry& entry = *entries_.peek();
    const BagConnection& connection = bag_.connections().at(entry.connection);
    RecordedMessage message{entry.time, &connection,
                            read_ros1_message(reader_->read(entry), connection)};
    entries_.pop();
    return message;
  }

 private:
  const BagFile& bag_;
  BagEntries entries_;
  std::optional<BagMessageReader> reader_;
};

}  // namespace

std::unique_ptr<RecordedMessages> Ros1Bag::messages(BagSelection selection) const {
  return std::make_unique<Ros1Messages>(bag_, std::move(selection));
}

}  // namespace matchbox_slam
