# SPDX-License-Identifier: MIT
# known.awk - awk -v looked="FILE ..." -f known.awk LIST FINDINGS: of an analyzer's findings, "FILE:LINE:...: WORDS [CHECKER]" a
# line, those that the list of suppressions does not know. A line of the list is FILE CHECKER WORDS OF THE FINDING # reason;
# one that has no reason, or meets no finding in a file that was looked at (looked=all: in any), is told of, too.
# Neither analyzer understands what src/base/owned.h does: leaks of variables that it releases are passed over.
function is_owned(finding,    part, name, line, n, owned, in_owned) {
    if (finding !~ /[Ll]eak/ || !match(finding, /'[a-z_0-9.]+'|leak: [a-z_0-9.]+/)) return 0
    name = substr(finding, RSTART, RLENGTH)
    gsub(/'|leak: |\..*/, "", name) # a member is the variable's
    split(finding, part, ":")
    while (n++ < part[2] && (getline line < part[1]) > 0) {
        if (line ~ /(FREED|OWNED\(|ENDED_BY\(|json_auto_t)/) in_owned = 1
        if (in_owned && line ~ "[ *]" name "( =|,|;|$)") owned = 1
        else if (line ~ "[*]" name "( =|,|;|\\)|$)") owned = 0
        if (line ~ /;/) in_owned = 0
    }
    close(part[1])
    return owned
}
BEGIN { none = split(looked, names, " "); for (i in names) was_looked_at[names[i]] }
FNR == NR {
    if (/^#/ || NF == 0) next
    if (!match($0, / # ./)) { print FILENAME ":" FNR ": no reason: " $0; next }
    ++known
    whole[known] = $0; file[known] = $1; checker[known] = "[" $2 "]"
    words[known] = substr($0, length($1 " " $2 " ") + 1, RSTART - length($1 " " $2 " ") - 1)
    next
}
{
    is_known = is_owned($0)
    for (i = 1; i <= known; ++i)
        if (index($0, file[i] ":") == 1 && index($0, words[i]) && substr($0, length($0) - length(checker[i]) + 1) == checker[i])
            is_known = met[i] = 1
    if (!is_known) print
}
END {
    for (i = 1; i <= known; ++i)
        if (!met[i] && (looked == "all" || file[i] in was_looked_at)) print "suppressed, and not found: " whole[i]
}
