/* SPDX-License-Identifier: MIT */
/* dicom_elements.h - elements of a DICOM data set, as texts and numbers. */
#pragma once

#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

using gdcm::DataSet;
using gdcm::Tag;
using Numbers = std::vector<double>;

/* The items of a sequence. They live no longer than this object. A sequence whose type the file lacks (VR UN) is
 * made of its bytes on request, and belongs to the caller. */
class Items {
public:
    Items(const DataSet *set, const Tag &tag)
    {
        if (set && set->FindDataElement(tag))
            items_ = set->GetDataElement(tag).GetValueAsSQ();
    }
    size_t count() const
    {
        return items_ ? items_->GetNumberOfItems() : 0;
    }
    const DataSet *at(size_t i) const
    {
        return i < count() ? &items_->GetItem(i + 1).GetNestedDataSet() : nullptr;
    }

private:
    gdcm::SmartPointer<gdcm::SequenceOfItems> items_;
};

/* Returns the bytes of an element, without padding; empty if it is missing. */
inline std::string bytes_in(const DataSet *set, const Tag &tag)
{
    const gdcm::ByteValue *value = set && set->FindDataElement(tag) ? set->GetDataElement(tag).GetByteValue() : nullptr;
    return value ? std::string(value->GetPointer(), value->GetLength()) : "";
}

inline std::string text_in(const DataSet *set, const Tag &tag)
{
    std::string text = bytes_in(set, tag);
    text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
    const size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
    return first == std::string::npos ? "" : text.substr(first, last + 1 - first);
}

inline std::vector<std::string> words_of(const std::string &text)
{
    std::vector<std::string> words;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\\', at), text.size());
        words.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return words;
}

/* Reads decimals between backslashes; none if one of them is not a finite number. */
inline Numbers decimals_of(const std::string &text)
{
    Numbers values;
    for (const auto &word : words_of(text)) {
        char *end;
        values.push_back(strtod(word.c_str(), &end));
        if (end == word.c_str() || !std::isfinite(values.back()))
            return {};
    }
    return values;
}

inline Numbers decimals_in(const DataSet *set, const Tag &tag)
{
    return decimals_of(text_in(set, tag));
}

/* Returns a binary number, which GDCM gives in the machine's byte order; NAN: missing. */
template <typename T> inline double binary_in(const DataSet *set, const Tag &tag)
{
    const std::string bytes = bytes_in(set, tag);
    T value;
    if (bytes.size() < sizeof value)
        return NAN;
    memcpy(&value, bytes.data(), sizeof value);
    return static_cast<double>(value);
}

inline std::string binary_text(double value)
{
    char text[40];
    snprintf(text, sizeof text, "%.17g", value);
    return std::isnan(value) ? "" : text;
}
