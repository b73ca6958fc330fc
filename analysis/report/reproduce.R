# Makes the primary tests of this report again, in base R, from tables/scores.csv, and prints what
# the report has (tables/tests.csv) beside what R finds; then the crossover analyses, comparisons by
# other tests, equivalence, correlations, agreement and Kruskal-Wallis tests, in base R too, the
# analyses of variance (package car) and the mixed models (package lmerTest). Nothing is taken from
# the report but who is compared with whom, and how.
#
#   Rscript reproduce.R
#
# Where the package coin is installed, its exact signed-rank test is made as well. What needs a
# package that is not there is named and left out. The script ends with status 1 if a number differs
# by more than a relative 1e-6 (of mixed models 1e-5: both search for the largest likelihood).

LARGEST_DIFFERENCE <- 1e-6
LARGEST_OF_A_SEARCH <- 1e-5
MOST_OF_ROUNDING <- 1e-3  # SD of people over that of residuals: the search stops so far from 0
MOST_FOR_INTERVAL <- 30   # pairs: the interval is found by trying every shift
MOST_FOR_WALSH <- 3000    # pairs: n (n + 1) / 2 averages are made

script <- sub("^--file=", "", grep("^--file=", commandArgs(FALSE), value = TRUE))
folder <- if (length(script)) dirname(script[1]) else "."

# Everything is read as text: a score called T is no TRUE, a participant called 007 no number. The
# apostrophe that keeps a spreadsheet from computing a text such as =a is taken off again.
read_table <- function(name) {
  found <- read.csv(file.path(folder, "tables", paste0(name, ".csv")), colClasses = "character",
                    na.strings = "", check.names = FALSE, encoding = "UTF-8", quote = "\"")
  plain <- function(text) sub("^'('*[=+@\t\r\n-])", "\\1", text)
  names(found) <- plain(names(found))
  found[] <- lapply(found, plain)
  found
}

# The names in a cell that is a line of CSV itself.
names_in <- function(cell) {
  if (is.na(cell)) return(character())
  scan(text = cell, what = "", sep = ",", quote = "\"", na.strings = character(), quiet = TRUE,
       encoding = "UTF-8")
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
compare <- function(test, what, expected, found, about = paste(test$a, "minus", test$b),
                    size = 1e-9, largest = LARGEST_DIFFERENCE) {
  expected <- suppressWarnings(as.numeric(expected))
  if (is.na(expected)) return(invisible())   # the report has none
  difference <- if (is.na(found)) Inf else abs(found - expected) / max(abs(expected), size)
  rows[[length(rows) + 1]] <<- data.frame(
    comparison = about, score = test$outcome, number = what, report = signif(expected, 9),
    R = signif(found, 9), difference = signif(difference, 2), wrong = !(difference <= largest))
}

scores <- read_table("scores")
needed <- c("not_tested", "timepoint_a", "timepoint_b", "ranked_worst", "family", "p_holm")
tests <- if (file.exists(file.path(folder, "tables", "tests.csv"))) read_table("tests") else {
  as.data.frame(sapply(needed, function(name) character(), simplify = FALSE))
}
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
    at <- function(level) interval(d, test$zero_method, test$alternative, exact, level) * pairs$unit
    ends <- at(1 - as.numeric(test$confidence))
    compare(test, "interval, low", test$hodges_lehmann_low, ends[1])
    compare(test, "interval, high", test$hodges_lehmann_high, ends[2])
    ends <- at(as.numeric(test$level))   # in a family: that at which Holm's method decides
    compare(test, "interval (Holm), low", test$hodges_lehmann_holm_low, ends[1])
    compare(test, "interval (Holm), high", test$hodges_lehmann_holm_high, ends[2])
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

# The models. Names of factors and levels may be anything: they are f1, f2, ... and numbers here.
TIMES <- " \u00d7 "
MINUS <- " \u2212 "
read_if_there <- function(name) {
  if (file.exists(file.path(folder, "tables", paste0(name, ".csv")))) {
    found <- read_table(name)
    if ("not_tested" %in% names(found)) found <- found[is.na(found$not_tested), , drop = FALSE]
    if (nrow(found)) found
  }
}
not_here <- function(...) cat("Not made here:", ..., "\n")
models <- 0

# The two-period crossover: t tests of half differences and of means of the periods, by sequence.
crossover <- function(found) {
  mine <- scores[scores$condition %in% c(found$a[1], found$b[1]) &
                 !is.na(scores[[found$outcome[1]]]), ]
  mine$score <- as.numeric(mine[[found$outcome[1]]])
  cell <- list(mine$participant, factor(mine$condition, c(found$a[1], found$b[1])))
  places <- tapply(mine$position, cell, function(p) length(unique(p)))
  count <- tapply(mine$score, cell, length)
  enough <- t(t(count) >= as.numeric(c(found$planned_a[1], found$planned_b[1])))
  kept <- rowSums(enough & places == 1) %in% 2
  score <- tapply(mine$score, cell, mean)[kept, , drop = FALSE]
  place <- tapply(as.numeric(mine$position), cell, min)[kept, , drop = FALSE]
  ab <- place[, 1] < place[, 2]
  one <- ifelse(ab, score[, 1], score[, 2]); two <- ifelse(ab, score[, 2], score[, 1])
  half <- (one - two) / 2; mean <- (one + two) / 2
  sides <- list(condition = list(half[ab], half[!ab]), period = list(-half[ab], half[!ab]),
                sequence = list(mean[!ab], mean[ab]))
  for (k in seq_len(nrow(found))) {
    line <- found[k, ]; side <- sides[[line$effect]]
    if (is.na(line$t)) next
    test <- t.test(side[[1]], side[[2]], var.equal = TRUE)
    about <- paste0("crossover, ", line$effect)
    compare(line, "estimate", line$estimate, unname(diff(rev(test$estimate))), about, size = 1e-6)
    compare(line, "standard error", line$standard_error, test$stderr, about)
    compare(line, "t", line$t, unname(test$statistic), about, size = 1e-6)
    compare(line, "p", line$p, test$p.value, about)
  }
}
found <- read_if_there("crossover")
if (!is.null(found)) {
  for (one in split(found, paste(found$a, found$b, found$outcome))) {
    crossover(one)
    models <- models + 1
  }
}

# Every order of some names.
orders <- function(names) {
  if (length(names) < 2) return(list(names))
  each <- function(k) lapply(orders(names[-k]), function(rest) c(names[k], rest))
  do.call(c, lapply(seq_along(names), each))
}

# The analysis of variance of participants with a score in every cell.
anova_of <- function(found, columns) {
  names <- sub("^anova: ", "", columns)
  between <- names_in(found$between[1])
  mine <- data.frame(who = scores$participant, score = as.numeric(scores[[found$outcome[1]]]))
  called <- setNames(paste0("f", seq_along(names)), names)
  for (k in seq_along(names)) mine[[called[k]]] <- scores[[columns[k]]]
  mine <- mine[complete.cases(mine), ]
  within <- called[setdiff(names, between)]; between <- called[between]
  cell <- if (length(within)) do.call(paste, c(mine[within], sep = "\r")) else rep("", nrow(mine))
  wide <- tapply(mine$score, list(mine$who, cell), mean)
  wide <- wide[complete.cases(wide) & rownames(wide) %in% names_in(found$people_in_it[1]), ,
               drop = FALSE]
  people <- mine[match(rownames(wide), mine$who), between, drop = FALSE]
  people[] <- lapply(people, factor)
  old <- options(contrasts = c("contr.sum", "contr.poly")); on.exit(options(old))
  side <- if (length(between)) paste(between, collapse = "*") else "1"
  type <- found$type[1]
  if (!length(within)) {
    people$score <- wide[, 1]
    fit <- lm(as.formula(paste("score ~", side)), people)
    if (deviance(fit) <= 1e-20 * sum((people$score - mean(people$score))^2)) {
      not_here("the ANOVA of", found$outcome[1], "(groups are all that differs)")
      return(invisible())
    }
    made <- car::Anova(fit, type = type)
    made <- made[!rownames(made) %in% c("(Intercept)", "Residuals"), ]
    univariate <- cbind(made[, "Sum Sq"], made[, "F value"], made[, "Pr(>F)"])
    rownames(univariate) <- rownames(made); corrected <- NULL
  } else {
    fit <- lm(as.formula(paste("wide ~", side)), people)
    idata <- mine[match(colnames(wide), cell), within, drop = FALSE]
    idata[] <- lapply(idata, factor)
    # It warns of error matrices that leave no epsilon, and of epsilons above 1.
    made <- suppressWarnings(summary(car::Anova(fit, idata = idata, type = type,
      idesign = as.formula(paste("~", paste(within, collapse = "*")))), multivariate = FALSE))
    univariate <- unclass(made$univariate.tests)[, c("Sum Sq", "F value", "Pr(>F)"), drop = FALSE]
    corrected <- made$pval.adjustments
  }
  effects <- lapply(strsplit(rownames(univariate), ":", TRUE), function(term) {
    vapply(orders(names[match(term, called)]), paste, "", collapse = TIMES)
  })
  for (k in seq_len(nrow(found))) {
    line <- found[k, ]
    row <- which(vapply(effects, function(called) line$effect %in% called, logical(1)))
    about <- paste("ANOVA,", line$effect)
    if (!length(row) || is.na(line$f)) next
    compare(line, "sum of squares", line$sum_of_squares, univariate[row, 1], about, size = 1e-6)
    compare(line, "F", line$f, univariate[row, 2], about, size = 1e-6)
    compare(line, "p", line$p, univariate[row, 3], about)
    if (rownames(univariate)[row] %in% rownames(corrected)) {
      epsilon <- corrected[rownames(univariate)[row], ]
      if (anyNA(epsilon)) next
      compare(line, "epsilon, GG", line$greenhouse_geisser, epsilon[["GG eps"]], about)
      compare(line, "p, GG", line$p_greenhouse_geisser, epsilon[["Pr(>F[GG])"]], about)
      compare(line, "epsilon, HF", line$huynh_feldt, min(1, epsilon[["HF eps"]]), about)
    }
  }
}
found <- read_if_there("anova")
columns <- grep("^anova: ", names(scores), value = TRUE)
if (!is.null(found) && !length(columns)) {
  not_here("the ANOVA over time (its data are not in scores.csv)")
} else if (!is.null(found) && !requireNamespace("car", quietly = TRUE)) {
  not_here("the ANOVA (package car is not installed)")
} else if (!is.null(found)) {
  for (one in split(found, found$outcome)) {
    anova_of(one, columns)
    models <- models + 1
  }
}

# The mixed model with a random participant; the level after the minus sign is the reference.
mixed_of <- function(found) {
  terms <- found[!is.na(found$estimate), ]; whole <- found[!is.na(found$f), ]
  called <- setNames(paste0("f", seq_len(nrow(whole))), whole$term)
  mine <- data.frame(who = scores$participant, score = as.numeric(scores[[found$outcome[1]]]))
  coefficient <- character()
  for (name in whole$term) {
    column <- scores[[paste0("mixed: ", name)]]
    pairs <- expand.grid(level = unique(column), reference = unique(column),
                         stringsAsFactors = FALSE)
    pairs$term <- paste0(name, ": ", pairs$level, MINUS, pairs$reference)
    own <- pairs[match(intersect(terms$term, pairs$term), pairs$term), ]
    if (nrow(own)) {   # in the order of the terms: that of a locale is another
      mine[[called[name]]] <- factor(match(column, c(own$reference[1], own$level)))
      coefficient[own$term] <- paste0(called[name], 1 + seq_len(nrow(own)))
    } else {
      mine[[called[name]]] <- as.numeric(column)
      coefficient[name] <- called[name]
    }
  }
  mine <- mine[complete.cases(mine), ]
  formula <- as.formula(paste("score ~", paste(called, collapse = " + "), "+ (1 | who)"))
  precise <- lme4::lmerControl(optimizer = "bobyqa", check.conv.singular = "ignore",
                               optCtrl = list(rhobeg = 0.2, rhoend = 1e-12, maxfun = 1e5))
  fit <- lmerTest::lmer(formula, mine, control = precise)
  table <- coef(summary(fit)); omnibus <- anova(fit, type = "III")
  theta <- lme4::getME(fit, "theta")
  searched <- theta == 0 || theta > MOST_OF_ROUNDING
  if (!searched) not_here("df and p of the mixed model of", found$outcome[1],
                          "(people differ by nothing but what the search left)")
  of_search <- function(line, what, expected, value, size = 1e-9) {
    compare(line, what, expected, value, paste("mixed model,", line$term), size,
            LARGEST_OF_A_SEARCH)
  }
  for (k in seq_len(nrow(terms))) {
    line <- terms[k, ]; row <- table[coefficient[line$term], ]
    of_search(line, "estimate", line$estimate, row[["Estimate"]], as.numeric(line$standard_error))
    of_search(line, "standard error", line$standard_error, row[["Std. Error"]])
    if (!searched) next
    of_search(line, "df", line$df, row[["df"]])
    of_search(line, "p", line$p, row[["Pr(>|t|)"]])
  }
  for (k in seq_len(nrow(whole))) {
    line <- whole[k, ]; row <- omnibus[called[line$term], ]
    of_search(line, "F", line$f, row[["F value"]], 1e-2)
    if (searched) of_search(line, "p of F", line$p, row[["Pr(>F)"]])
  }
}
found <- read_if_there("mixed_models")
if (!is.null(found) && !requireNamespace("lmerTest", quietly = TRUE)) {
  not_here("the mixed models (package lmerTest is not installed)")
} else if (!is.null(found)) {
  for (one in split(found, found$outcome)) {
    mixed_of(one)
    models <- models + 1
  }
}

# Comparisons by other tests, and correlations: each person's mean over exposures.
others <- 0
means_of <- function(outcome, people, condition) {
  here <- is.na(condition) | scores$condition %in% condition
  mine <- here & !is.na(scores[[outcome]])
  means <- tapply(as.numeric(scores[[outcome]][mine]), scores$participant[mine], mean)
  unname(means[people])
}
unbiased <- function(df) exp(lgamma(df / 2) - lgamma((df - 1) / 2) - log(df / 2) / 2)

# The exact distribution of a rank sum given the ties, person after person: rows are people dealt to a.
rank_sum_p <- function(a, b, side) {
  twice <- round(2 * rank(signif(c(a, b), 12))); n <- length(a)
  ways <- matrix(0, n + 1, sum(twice) + 1); ways[1, 1] <- 1
  for (step in twice) {
    moved <- ways[seq_len(n), seq_len(ncol(ways) - step), drop = FALSE]
    ways[-1, -seq_len(step)] <- ways[-1, -seq_len(step)] + moved
  }
  p <- ways[n + 1, ] / sum(ways[n + 1, ])
  sums <- seq_along(p) - 1; found <- sum(twice[seq_len(n)]); middle <- n * (length(twice) + 1)
  switch(side, greater = sum(p[sums >= found]), less = sum(p[sums <= found]),
         sum(p[abs(sums - middle) >= abs(found - middle)]))
}

compare_means <- function(line, a, b) {
  side <- if (line$alternative == "two-sided") "two.sided" else line$alternative
  paired <- line$test == "paired_t"
  test <- t.test(a, b, paired = paired, var.equal = line$test == "student_t", alternative = side,
                 conf.level = as.numeric(line$confidence))
  mean <- mean(a) - mean(b)
  within <- if (paired) var(a - b) else {
    ((length(a) - 1) * var(a) + (length(b) - 1) * var(b)) / (length(a) + length(b) - 2)
  }
  df <- if (paired) length(a) - 1 else length(a) + length(b) - 2
  compare(line, "t", line$value, unname(test$statistic), size = 1e-6)
  compare(line, "df", line$df, unname(test$parameter))
  compare(line, "p", line$p, test$p.value)
  compare(line, "difference", line$difference_estimate, mean, size = 1e-6)
  compare(line, "interval, low", line$difference_low, test$conf.int[1], size = 1e-6)
  compare(line, "interval, high", line$difference_high, test$conf.int[2], size = 1e-6)
  if (df > 1) {
    compare(line, "Hedges' g", line$effect_estimate, mean / sqrt(within) * unbiased(df), size = 1e-6)
  }
}

compare_ranks <- function(line, a, b) {
  a <- signif(a, 12); b <- signif(b, 12)   # means of several exposures that are alike tie
  above <- outer(a, b, ">") + outer(a, b, "==") / 2
  compare(line, "U", line$value, sum(above))
  compare(line, "r", line$effect_estimate, 2 * mean(above) - 1, size = 1e-6)
  compare(line, "shift", line$difference_estimate, median(outer(a, b, "-")), size = 1e-6)
  if (line$method == "exact") compare(line, "p, exact", line$p, rank_sum_p(a, b, line$alternative))
}

compare_signs <- function(line, a, b) {
  d <- signif(a - b, 12); side <- line$alternative
  if (!any(d != 0)) return(invisible())
  test <- binom.test(sum(d > 0), sum(d != 0), alternative =
    if (side == "two-sided") "two.sided" else side)
  compare(line, "p", line$p, test$p.value)
  compare(line, "share above", line$effect_estimate, unname(test$estimate))
}

found <- read_if_there("comparisons")
for (k in seq_len(if (is.null(found)) 0 else nrow(found))) {
  line <- found[k, ]
  if (!is.na(line$timepoint_a) || !is.na(line$timepoint_b)) {
    not_here(line$outcome, line$a, "minus", line$b, "(its data are not in scores.csv)")
    next
  }
  a <- means_of(line$outcome, names_in(line$people_a), line$condition_a)
  b <- means_of(line$outcome, names_in(line$people_b), line$condition_b)
  switch(line$test, mann_whitney = compare_ranks(line, a, b), sign = compare_signs(line, a, b),
         compare_means(line, a, b))
  others <- others + 1
}

# ANALYSES

table <- do.call(rbind, rows)
if (is.null(table)) {
  cat("This report has no test.\n")
  quit(status = 0)
}
options(width = 140)
print(table[names(table) != "wrong"], row.names = FALSE)
wrong <- sum(table$wrong)
cat(sprintf(paste0("\n%d numbers of %d tests, %d other tests and %d models; largest relative difference %g; ",
                   "%d differ by more than %g (of mixed models %g).\n"),
            nrow(table), nrow(done), others, models, max(table$difference), wrong, LARGEST_DIFFERENCE,
            LARGEST_OF_A_SEARCH))
cat(R.version.string, "\n")
quit(status = if (wrong) 1 else 0)
