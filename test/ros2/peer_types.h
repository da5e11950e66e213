// The types of ros2/idl/messages.idl for Fast DDS, as fastddsgen makes them, by their names on the
// wire.
#pragma once

#include <fastdds/dds/topic/TypeSupport.hpp>
#include <string>

// Throws std::out_of_range for a name that is none of ours.
eprosima::fastdds::dds::TypeSupport make_type(const std::string& name);

// From now on types are announced with their TypeObject.
void announce_type_objects();
