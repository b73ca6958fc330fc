# Makes the primary tests of this report again, in base R, from tables/scores.csv, and prints what
# the report has (tables/tests.csv) beside what R finds. Nothing is taken from the report but who is
# compared with whom, and how.
#
#   Rscript reproduce.R
#
# Where the package coin is installed, its exact signed-rank test is made as well. The script ends
# with status 1 if a number differs by more than a relative 1e-6.

LARGEST_DIFFERENCE <- 1e-6
MOST_FOR_INTERVAL <- 30   # pairs: the interval is found by trying every shift
MOST_FOR_WALSH <- 3000    # pairs: n (n + 1) / 2 averages are made

script <- sub("^--file=", "", grep("^--file=", commandArgs(FALSE), value = TRUE))
folder <- if (length(script)) dirname(script[1]) else "."

# Everything is read as text: a score called T is no TRUE, a participant called 007 no number.
read_table <- function(name) {
  read.csv(file.path(folder, "tables", paste0(name, ".csv")), colClasses = "character",
           na.strings = "", check.names = FALSE, encoding = "UTF-8", quote = "\"")
}

# Sums over the exposures of each condition, brought to one number of exposures, of the people with
# every planned one. They stay integers, so that ties are exact.
pair_up <- function(scores, test) {
  raw <- as.numeric(scores[[paste0(test$outcome, "_raw")]])
  of <- function(condition) {
    mine <- scores$condition == condition
    list(sum = tapply(raw[mine], scores$participant[mine], sum),
         count = tapply(raw[mine], scores$participant[mine], length))
  }
  a <- of(test$a); b <- of(test$b)
  complete <- function(side, planned) {
    names(side$count)[side$count >= max(1, as.numeric(planned))]
  }
  people <- intersect(complete(a, test$planned_a), complete(b, test$planned_b))
  counts <- c(a$count[people], b$count[people])
  common <- Reduce(function(x, y) x * y / divisor(x, y), unique(counts), 1)
  weighted <- as.numeric(scores[[test$outcome]])
  place <- which(raw != 0)
  unit <- if (length(place)) weighted[place[1]] / raw[place[1]] else 0
  list(a = unname(a$sum[people] * common / a$count[people]),
       b = unname(b$sum[people] * common / b$count[people]), unit = unit / common)
}

divisor <- function(x, y) if (y == 0) x else divisor(y, x %% y)

# Wilcoxon's signed-rank test of integer differences. Zeros are ranked and then dropped (Pratt), or
# dropped before ranking. The exact distribution given the ties: every sign is as likely as the
# other, so that of the sum is found by adding one rank after another (in halves, to be whole).
signed_rank <- function(d, zeros, side) {
  if (zeros == "wilcox") d <- d[d != 0]
  r <- rank(abs(d))[d != 0]
  positive <- d[d != 0] > 0
  w_plus <- sum(r[positive]); w_minus <- sum(r[!positive])
  z <- if (length(r)) (w_plus - w_minus) / sqrt(sum(r^2)) else 0
  list(w_plus = w_plus, w_minus = w_minus, z = z, ranks = r,
       p_exact = exact_p(r, w_plus, side), p_asymptotic = normal_p(z, side))
}

exact_p <- function(r, w_plus, side) {
  p <- 1
  for (step in round(2 * r)) p <- (c(p, numeric(step)) + c(numeric(step), p)) / 2
  at <- round(2 * w_plus) + 1
  up <- sum(p[at:length(p)]); down <- sum(p[1:at])
  switch(side, greater = up, less = down, min(1, 2 * min(up, down)))
}

normal_p <- function(z, side) {
  switch(side, greater = pnorm(-z), less = pnorm(z), 2 * pnorm(-abs(z)))
}

# The median of the Walsh averages.
hodges_lehmann <- function(d) {
  sums <- outer(d, d, "+")
  median(sums[upper.tri(sums, diag = TRUE)]) / 2
}

# The hull of the shifts that the test does not reject: p changes only at Walsh averages, so each of
# them is tried and a shift between neighbours, all times 4 to stay whole. An end is closed where
# the Walsh average itself is not rejected.
interval <- function(d, zeros, side, exact, level) {
  sums <- outer(d, d, "+")
  at <- sort(unique(2 * sums[upper.tri(sums, diag = TRUE)]))
  tried <- sort(c(at, at[-1] - diff(at) / 2, min(at) - 1, max(at) + 1))
  kept <- vapply(tried, function(shift) {
    found <- signed_rank(4 * d - shift, zeros, side)
    (if (exact) found$p_exact else found$p_asymptotic) > level
  }, logical(1))
  if (!any(kept)) return(c(NA, NA))
  first <- min(which(kept)); last <- max(which(kept))
  end <- function(place, step) {   # a kept shift between two averages: the end is the next average
    if (place %in% c(1, length(tried))) return(NA)
    if (tried[place] %in% at) tried[place] else tried[place + step]
  }
  c(end(first, -1), end(last, 1)) / 4
}

rows <- list()
compare <- function(test, what, expected, found) {
  expected <- suppressWarnings(as.numeric(expected))
  if (is.na(expected)) return(invisible())   # the report has none
  difference <- if (is.na(found)) Inf else abs(found - expected) / max(abs(expected), 1e-9)
  rows[[length(rows) + 1]] <<- data.frame(
    comparison = paste(test$a, "minus", test$b), score = test$outcome, number = what,
    report = signif(expected, 9), R = signif(found, 9), difference = signif(difference, 2))
}

scores <- read_table("scores")
tests <- read_table("tests")
done <- tests[is.na(tests$not_tested), , drop = FALSE]

# scores.csv has what was answered after exposures: no other moment, and nobody's assumed rank.
elsewhere <- !is.na(done$timepoint_a) | !is.na(done$timepoint_b) | done$ranked_worst != "0"
for (k in which(elsewhere)) {
  cat("Not made here:", done$outcome[k], done$a[k], "minus", done$b[k],
      "(its data are not in scores.csv)\n")
}
adjusted_here <- !(done$family %in% done$family[elsewhere])
done$p_holm[!adjusted_here] <- NA
done <- done[!elsewhere, , drop = FALSE]
p_values <- rep(NA_real_, nrow(done))
for (k in seq_len(nrow(done))) {
  test <- done[k, ]
  pairs <- pair_up(scores, test)
  d <- pairs$a - pairs$b
  exact <- test$method == "exact"
  found <- signed_rank(d, test$zero_method, test$alternative)
  p_values[k] <- if (exact) found$p_exact else found$p_asymptotic
  compare(test, "n", test$n, length(d))
  compare(test, "W+", test$w_plus, found$w_plus)
  compare(test, "W-", test$w_minus, found$w_minus)
  compare(test, "Z", test$z, found$z)
  compare(test, paste("p,", test$method), test$p, p_values[k])
  compare(test, "mean of a", test[[paste0("mean_", test$a)]], mean(pairs$a) * pairs$unit)
  compare(test, "mean of b", test[[paste0("mean_", test$b)]], mean(pairs$b) * pairs$unit)
  ranked <- signed_rank(d, "wilcox", test$alternative)
  if (length(ranked$ranks)) {
    r <- (ranked$w_plus - ranked$w_minus) / sum(ranked$ranks)
    compare(test, "rank-biserial r", test$rank_biserial, r)
  }
  kept <- if (test$zero_method == "wilcox") d[d != 0] else d
  if (length(kept) && length(kept) <= MOST_FOR_WALSH) {
    compare(test, "Hodges-Lehmann", test$hodges_lehmann, hodges_lehmann(kept) * pairs$unit)
  }
  bounded <- !is.na(test$hodges_lehmann_low) || !is.na(test$hodges_lehmann_high)
  if (bounded && test$shift_interval == "inverted_test" && length(kept) <= MOST_FOR_INTERVAL) {
    level <- 1 - as.numeric(test$confidence)
    ends <- interval(d, test$zero_method, test$alternative, exact, level) * pairs$unit
    compare(test, "interval, low", test$hodges_lehmann_low, ends[1])
    compare(test, "interval, high", test$hodges_lehmann_high, ends[2])
  }
  if (exact && requireNamespace("coin", quietly = TRUE) && any(d != 0)) {
    side <- test$alternative
    method <- if (test$zero_method == "pratt") "Pratt" else "Wilcoxon"
    of_coin <- coin::wilcoxsign_test(pairs$a ~ pairs$b, zero.method = method, alternative =
      if (side == "two-sided") "two.sided" else side, distribution = coin::exact())
    compare(test, "p, exact, of coin", test$p, as.numeric(coin::pvalue(of_coin)))
  }
}

# Holm's method over the tests of a family.
for (family in unique(done$family[!is.na(done$p_holm)])) {
  members <- which(!is.na(done$p_holm) & done$family %in% family)
  adjusted <- p.adjust(p_values[members], "holm")
  for (k in seq_along(members)) {
    compare(done[members[k], ], "p, Holm", done$p_holm[members[k]], adjusted[k])
  }
}

table <- do.call(rbind, rows)
if (is.null(table)) {
  cat("This report has no test.\n")
  quit(status = 0)
}
options(width = 140)
print(table, row.names = FALSE)
wrong <- sum(!(table$difference <= LARGEST_DIFFERENCE))
cat(sprintf("\n%d numbers of %d tests; largest relative difference %g; %d differ by more than %g.\n",
            nrow(table), nrow(done), max(table$difference), wrong, LARGEST_DIFFERENCE))
cat(R.version.string, "\n")
quit(status = if (wrong) 1 else 0)
