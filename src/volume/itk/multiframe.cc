/* SPDX-License-Identifier: MIT */
#include "volume/itk/multiframe.h"

#include <gdcmAttribute.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>

#include <cmath>
#include <cstdlib>

namespace {

using gdcm::DataSet;
using gdcm::Tag;

/* The first item of a sequence, or none. It lives no longer than this: a sequence whose type the file does not say (VR UN) is
 * made of its bytes when it is asked for, and belongs to who asked. */
class Item {
public:
    Item(const DataSet *set, const Tag &tag)
    {
        if (!set || !set->FindDataElement(tag))
            return;
        items_ = set->GetDataElement(tag).GetValueAsSQ();
        if (items_ && items_->GetNumberOfItems() > 0)
            set_ = &items_->GetItem(1).GetNestedDataSet();
    }
    operator const DataSet *() const
    {
        return set_;
    }

private:
    gdcm::SmartPointer<gdcm::SequenceOfItems> items_;
    const DataSet *set_ = nullptr;
};

/* An element as bytes; empty where it is not there. */
std::string bytes_in(const DataSet *set, const Tag &tag)
{
    const gdcm::ByteValue *value = set && set->FindDataElement(tag) ? set->GetDataElement(tag).GetByteValue() : nullptr;
    return value ? std::string(value->GetPointer(), value->GetLength()) : "";
}

/* Decimals between backslashes. */
std::vector<double> decimals_in(const DataSet *set, const Tag &tag)
{
    const std::string text = bytes_in(set, tag);
    std::vector<double> values;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\\', at), text.size());
        values.push_back(strtod(text.substr(at, end - at).c_str(), nullptr));
        at = end + 1;
    }
    return values;
}

/* A binary number, of little-endian files. */
template <typename T> std::string binary_in(const DataSet *set, const Tag &tag)
{
    const std::string bytes = bytes_in(set, tag);
    T value;
    if (bytes.size() < sizeof value)
        return "";
    memcpy(&value, bytes.data(), sizeof value);
    char text[40];
    snprintf(text, sizeof text, "%.17g", static_cast<double>(value));
    return text;
}

/* What stack.h calls these, of a frame's own groups. */
std::vector<std::string> keys_of(const DataSet *frame)
{
    const Item content(frame, Tag(0x0020, 0x9111));
    std::vector<std::string> keys;
    for (const auto &key : plane_keys) {
        const std::string tag = key.tag;
        keys.push_back(
            tag == "0020|0100"   ? binary_in<uint32_t>(content, Tag(0x0020, 0x9128))
            : tag == "0018|1060" ? binary_in<double>(Item(frame, Tag(0x0018, 0x9118)), Tag(0x0020, 0x9153))
            : tag == "0008|002a" ? bytes_in(content, Tag(0x0018, 0x9074))
            : tag == "0018|0081" ? binary_in<double>(Item(frame, Tag(0x0018, 0x9114)), Tag(0x0018, 0x9082))
            : tag == "0018|9087" ? binary_in<double>(Item(frame, Tag(0x0018, 0x9117)), Tag(0x0018, 0x9087))
                                 : "");
    }
    return keys;
}

/* Of the frame or of all: the steps from pixel to pixel, u and then v; empty where one of their numbers is missing. GDCM
 * takes 1 mm for both where several frames stand at one place. */
std::vector<double> pixel_steps(const DataSet *frame, const DataSet *shared)
{
    const auto either = [&](const Tag &group, const Tag &tag, size_t count) {
        const auto own = decimals_in(Item(frame, group), tag);
        return own.size() == count ? own : decimals_in(Item(shared, group), tag);
    };
    auto steps = either(Tag(0x0020, 0x9116), Tag(0x0020, 0x0037), 6);
    const auto spacing = either(Tag(0x0028, 0x9110), Tag(0x0028, 0x0030), 2); /* between rows, then between columns */
    if (steps.size() != 6 || spacing.size() != 2 || !(spacing[0] > 0) || !(spacing[1] > 0))
        return {};
    for (size_t i = 0; i < 6; ++i)
        steps[i] *= spacing[i < 3 ? 1 : 0];
    return steps;
}

bool differ(const std::vector<double> &a, const std::vector<double> &b)
{
    bool any = a.size() != b.size();
    for (size_t i = 0; !any && i < a.size(); ++i)
        any = !(std::fabs(a[i] - b[i]) <= 1e-4);
    return any;
}

std::vector<double> scale_of(const DataSet *frame)
{
    const Item group(frame, Tag(0x0028, 0x9145));
    auto scale = decimals_in(group, Tag(0x0028, 0x1053));
    for (const double intercept : decimals_in(group, Tag(0x0028, 0x1052)))
        scale.push_back(intercept);
    return scale;
}

} // namespace

FramePlanes planes_in(const std::string &path, size_t frames)
{
    FramePlanes found;
    gdcm::Reader reader;
    reader.SetFileName(path.c_str());
    if (!reader.ReadUpToTag(Tag(0x7fe0, 0x0010)))
        return found;
    const DataSet &all = reader.GetFile().GetDataSet();
    const Tag spacing[] = {Tag(0x3004, 0x000c), Tag(0x0018, 0x0088), Tag(0x0018, 0x0050)};
    for (const auto &tag : spacing)
        found.is_spaced = found.is_spaced || !bytes_in(&all, tag).empty();
    const Tag groups(0x5200, 0x9230);
    const auto items = all.FindDataElement(groups) ? all.GetDataElement(groups).GetValueAsSQ() : nullptr;
    if (!items || frames == 0 || items->GetNumberOfItems() != frames)
        return found;
    const Item shared(&all, Tag(0x5200, 0x9229));
    const Item measures(shared, Tag(0x0028, 0x9110));
    found.is_spaced = found.is_spaced || !bytes_in(measures, Tag(0x0018, 0x0088)).empty();
    std::vector<double> turned, scale;
    for (size_t i = 0; i < frames; ++i) {
        const DataSet *frame = &items->GetItem(i + 1).GetNestedDataSet();
        const auto place = decimals_in(Item(frame, Tag(0x0020, 0x9113)), Tag(0x0020, 0x0032));
        const auto own_turn = pixel_steps(frame, shared), own_scale = scale_of(frame);
        if (place.size() != 3 || own_turn.size() != 6) {
            found.planes.clear();
            return found;
        }
        if (i > 0 && differ(turned, own_turn))
            fail(ISO_E_FORMAT, path + ": its frames 1 and " + std::to_string(i + 1) + " are turned against each other");
        if (i > 0 && differ(scale, own_scale))
            fail(ISO_E_FORMAT, path + ": its frames 1 and " + std::to_string(i + 1) +
                                   " have different rescale slopes or intercepts, which is not read of one file");
        turned = own_turn, scale = own_scale;
        Plane plane;
        plane.name = "frame " + std::to_string(i + 1);
        plane.first = {place[0], place[1], place[2]};
        plane.keys = keys_of(frame);
        found.planes.push_back(plane);
    }
    found.u = {turned[0], turned[1], turned[2]};
    found.v = {turned[3], turned[4], turned[5]};
    return found;
}
