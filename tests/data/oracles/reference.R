# What R says about the data sets beside it: writes r_output.csv and r_session.txt.
# Run once, in this folder: Rscript reference.R
# Debian: r-base-core r-cran-{car,coin,effectsize,exactranktests,lme4,lmertest}
suppressPackageStartupMessages({
  library(car)
  library(coin)
  library(effectsize)
  library(exactRankTests)
  library(lmerTest)
})
options(warn = 1)

found <- list()
add <- function(analysis, dataset, ...) {
  values <- c(...)
  stopifnot(!is.null(names(values)), all(nzchar(names(values))))
  text <- ifelse(is.finite(values), sprintf("%.17g", values), "")
  found[[length(found) + 1]] <<- data.frame(
    analysis = analysis, dataset = dataset, quantity = names(values), value = text
  )
}
prefixed <- function(prefix, values) setNames(values, paste0(prefix, names(values)))
by_dataset <- function(file) {
  table <- read.csv(file, colClasses = c(participant = "character"), na.strings = "")
  split(table, factor(table$dataset, unique(table$dataset)))
}

# --- Signed ranks: coin is exact with ties, and has both treatments of zeros -----------------
SIDES <- c("two-sided" = "two.sided", greater = "greater", less = "less")

coin_tests <- function(d, zeros) {
  long <- data.frame(
    y = c(d, 0 * d), x = factor(rep(c("first", "second"), each = length(d))),
    block = factor(rep(seq_along(d), 2))
  )
  values <- c()
  for (side in names(SIDES)) {
    for (method in c("exact", "asymptotic")) {
      test <- wilcoxsign_test(
        y ~ x | block, long, zero.method = zeros, distribution = method,
        alternative = SIDES[[side]]
      )
      values[paste0("p_", method, " ", side)] <- as.numeric(pvalue(test))
    }
  }
  c(z = as.numeric(statistic(test, type = "standardized")), values)
}

# Sums of positive and negative ranks; `rank` gives midranks.
rank_sums <- function(d, zeros) {
  if (zeros == "Wilcoxon") d <- d[d != 0]
  ranks <- rank(abs(d))
  c(w_plus = sum(ranks[d > 0]), w_minus = sum(ranks[d < 0]))
}

# Median of the Walsh averages, and the order statistics that wilcox.test takes when it is exact.
shift_of <- function(d, unit, confidence) {
  walsh <- outer(d, d, "+") / 2 * unit
  walsh <- sort(walsh[!lower.tri(walsh)])
  n <- length(d)
  values <- c(estimate = median(walsh))
  if (n >= 6) {
    rank <- max(qsignrank((1 - confidence) / 2, n), 1)
    bounds <- walsh[c(rank, n * (n + 1) / 2 - rank + 1)]
    coverage <- 1 - 2 * psignrank(rank - 1, n)
    values <- c(values, low = bounds[1], high = bounds[2], coverage = coverage)
  }
  values
}

rank_biserial_of <- function(...) {
  r <- effectsize::rank_biserial(..., ci = 0.95, verbose = FALSE)
  c(estimate = r$r_rank_biserial, low = r$CI_low, high = r$CI_high)
}

paired_t <- function(d) {
  test <- t.test(d)
  one_sided <- sapply(c("greater", "less"), function(side) t.test(d, alternative = side)$p.value)
  c(
    n = length(d), mean = mean(d), standard_error = test$stderr, df = unname(test$parameter),
    t = unname(test$statistic), "p two-sided" = test$p.value,
    setNames(one_sided, paste("p", names(one_sided))),
    low = test$conf.int[1], high = test$conf.int[2],
    greater_low = t.test(d, alternative = "greater")$conf.int[1],
    cohen_dz = mean(d) / sd(d)
  )
}

for (set in by_dataset("pairs.csv")) {
  name <- set$dataset[1]
  unit <- set$unit[1]
  whole <- set[complete.cases(set), ]
  d <- whole$a - whole$b
  if (length(d) > 1 && sd(d) > 0) add("paired_t", name, paired_t(d * unit))
  add("signed_rank", name, c(n = length(d), zeros = sum(d == 0)))
  for (zeros in c("Pratt", "Wilcoxon")) {
    prefix <- c(Pratt = "pratt ", Wilcoxon = "wilcox ")[[zeros]]
    add("signed_rank", name, prefixed(prefix, rank_sums(d, zeros)))
    if (any(d != 0)) add("signed_rank", name, prefixed(prefix, coin_tests(d, zeros)))
    kept <- if (zeros == "Pratt") d else d[d != 0]
    if (length(kept)) {
      for (confidence in c(0.95, 0.9)) {
        values <- shift_of(kept, unit, confidence)
        add("shift", name, prefixed(sprintf("%s%g ", prefix, confidence), values))
      }
    }
  }
  # A second authority: another algorithm, and base R where neither ties nor zeros are there.
  if (any(d != 0)) {
    for (side in names(SIDES)) {
      p <- wilcox.exact(d[d != 0], exact = TRUE, alternative = SIDES[[side]])$p.value
      add("signed_rank", name, setNames(p, paste0("wilcox p_exact_of_exactRankTests ", side)))
    }
  }
  if (!any(d == 0) && !anyDuplicated(abs(d))) {
    test <- wilcox.test(d, exact = TRUE)
    add("signed_rank", name, c(`pratt p_exact_of_wilcox.test two-sided` = test$p.value))
    if (length(d) >= 6) {
      test <- wilcox.test(d, exact = TRUE, conf.int = TRUE)
      values <- c(estimate = unname(test$estimate), low = test$conf.int[1], high = test$conf.int[2])
      add("shift", name, prefixed("pratt 0.95 of_wilcox.test ", values * unit))
    }
  }
  # The interval of one sample counts the differences, that of pairs the first condition.
  if (sum(d != 0) >= 6) {
    add("rank_biserial", name, rank_biserial_of(d))
    paired <- rank_biserial_of(whole$a, whole$b, paired = TRUE)
    add("rank_biserial", name, prefixed("paired ", paired[c("low", "high")]))
  } else if (any(d != 0)) {
    add("rank_biserial", name, rank_biserial_of(d)["estimate"])
  }
  # Who has one half only: a difference larger than any, against the condition that is missing.
  lost <- is.na(set$b) - is.na(set$a)
  if (any(lost != 0)) {
    worst <- c(d, -lost[lost != 0] * (max(abs(d)) + 1))
    add("worst_rank", name, coin_tests(worst, "Pratt"))
  }
}

# --- Crossover: the closed form by t tests, and the mixed model that it equals ----------------
t_row <- function(estimate, se, df) {
  half <- qt(0.975, df) * se
  c(
    estimate = estimate, standard_error = se, df = df, t = estimate / se,
    p = 2 * pt(-abs(estimate / se), df), low = estimate - half, high = estimate + half
  )
}
t_of <- function(x, y) {
  test <- t.test(x, y, var.equal = TRUE)
  c(
    estimate = unname(test$estimate[1] - test$estimate[2]), standard_error = test$stderr,
    df = unname(test$parameter), t = unname(test$statistic), p = test$p.value,
    low = test$conf.int[1], high = test$conf.int[2]
  )
}
# The search for the maximum of the likelihood goes on for as long as digits change.
PRECISE <- lmerControl(
  optimizer = "bobyqa", optCtrl = list(rhobeg = 0.2, rhoend = 1e-12, maxfun = 1e5)
)

for (set in by_dataset("crossovers.csv")) {
  name <- set$dataset[1]
  set$score <- as.numeric(set$score)
  incomplete <- unique(set$participant[is.na(set$score)])
  set <- set[!set$participant %in% incomplete, ]
  wide <- reshape(
    set[c("participant", "sequence", "period", "score")], direction = "wide",
    idvar = c("participant", "sequence"), timevar = "period"
  )
  ab <- wide$sequence == "ab"
  half <- (wide$score.1 - wide$score.2) / 2
  mean <- (wide$score.1 + wide$score.2) / 2
  add("crossover", name, c(n_ab = sum(ab), n_ba = sum(!ab)))
  add("crossover", name, prefixed("condition ", t_of(half[ab], half[!ab])))
  add("crossover", name, prefixed("period ", t_of(-half[ab], half[!ab])))
  add("crossover", name, prefixed("sequence ", t_of(mean[!ab], mean[ab])))
  set$condition <- relevel(factor(set$condition), "b")
  set$period <- factor(set$period)
  model <- lmer(score ~ condition + period + sequence + (1 | participant), set, control = PRECISE)
  table <- coef(summary(model))
  rownames(table) <- sub("conditiona", "condition", sub("period2", "period", rownames(table)))
  rownames(table) <- sub("sequenceba", "sequence", rownames(table))
  for (term in c("condition", "period", "sequence")) {
    values <- t_row(table[term, "Estimate"], table[term, "Std. Error"], table[term, "df"])
    add("crossover", name, prefixed(paste(term, "of_lmer "), values))
  }
}

# --- Analysis of variance ---------------------------------------------------------------------
noncentrality <- function(f, df1, df2, probability) {
  excess <- function(ncp) pf(f, df1, df2, ncp) - probability
  if (pf(f, df1, df2) <= probability) return(0)
  high <- 1
  while (excess(high) > 0) high <- 2 * high
  uniroot(excess, c(0, high), tol = 1e-12)$root
}
eta_interval <- function(f, df1, df2, confidence = 0.9) {
  tail <- (1 - confidence) / 2
  ncp <- c(noncentrality(f, df1, df2, 1 - tail), noncentrality(f, df1, df2, tail))
  setNames(ncp / (ncp + df1 + df2 + 1), c("low", "high"))
}

CORRECTIONS <- c("greenhouse_geisser", "p_greenhouse_geisser", "huynh_feldt", "p_huynh_feldt")

# The same test by base R: the model of the contrasts with and without the effect's columns.
base_table <- function(contrasted, group, effect) {
  grouped <- nlevels(group) > 1
  x <- if (grouped) model.matrix(~group)[, -1]
  full <- if (grouped) lm(contrasted ~ x) else lm(contrasted ~ 1)
  null <- if (startsWith(effect, "group")) lm(contrasted ~ 1) else
    if (grouped) lm(contrasted ~ 0 + x) else lm(contrasted ~ 0)
  row <- anova(full, null, test = "Spherical")[2, ]
  c(
    f_of_anova.mlm = row[["F"]], p_of_anova.mlm = row[["Pr(>F)"]],
    p_greenhouse_geisser_of_anova.mlm = row[["G-G Pr"]],
    p_huynh_feldt_of_anova.mlm = row[["H-F Pr"]]
  )
}

# Orthonormal contrasts of a within effect, made apart from car: for Mauchly's test of a term.
contrasts_of <- function(levels, used) {
  together <- matrix(1)
  for (factor in names(levels)) {
    k <- levels[[factor]]
    part <- if (factor %in% used) contr.helmert(k) else matrix(1, k, 1)
    together <- kronecker(together, sweep(part, 2, sqrt(colSums(part^2)), "/"))
  }
  together
}

for (set in by_dataset("designs.csv")) {
  name <- set$dataset[1]
  set$score <- as.numeric(set$score)
  within <- Filter(function(f) !all(is.na(set[[f]])), c("condition", "scene"))
  between <- !all(is.na(set$group))
  set$cell <- if (length(within)) do.call(paste, set[within]) else "only"
  cells <- set[!duplicated(set$cell), c("cell", within), drop = FALSE]
  cells <- cells[do.call(order, unname(as.list(cells[c(within, "cell")]))), , drop = FALSE]
  wide <- tapply(set$score, list(set$participant, set$cell), identity)[, cells$cell, drop = FALSE]
  excluded <- sum(!complete.cases(wide))
  wide <- wide[complete.cases(wide), , drop = FALSE]
  group <- factor(set$group[match(rownames(wide), set$participant)])
  add("anova", name, c(n = nrow(wide), excluded = excluded))

  if (between) contrasts(group) <- contr.sum(nlevels(group))
  if (length(within)) {
    model <- if (between) lm(wide ~ group) else lm(wide ~ 1)
    idata <- as.data.frame(lapply(cells[within], factor))
    design <- as.formula(paste("~", paste(within, collapse = "*")))
    tables <- Anova(model, idata = idata, idesign = design, type = 3)
    out <- suppressWarnings(summary(tables, multivariate = FALSE))
    univariate <- unclass(out$univariate.tests)
    univariate <- univariate[rownames(univariate) != "(Intercept)", , drop = FALSE]
    colnames(univariate) <- c("ss", "df", "error_ss", "df_error", "f", "p")
    # An error term belongs to the within part of an effect and is counted once.
    strata <- gsub("^group:?", "", rownames(univariate))
  } else {
    scores <- wide[, 1]
    table <- Anova(lm(scores ~ group), type = 3)
    univariate <- cbind(
      ss = table["group", 1], df = table["group", 2], error_ss = table["Residuals", 1],
      df_error = table["Residuals", 2], f = table["group", 3], p = table["group", 4]
    )
    rownames(univariate) <- "group"
    strata <- ""
    out <- list()
  }
  if (between && length(within)) {
    second <- summary(Anova(model, idata = idata, idesign = design, type = 2), multivariate = FALSE)
    second <- unclass(second$univariate.tests)[rownames(univariate), c(1, 5, 6)]
    colnames(second) <- c("ss", "f", "p")
    for (effect in rownames(second)) {
      add("anova_type_ii", name, prefixed(paste0(gsub(":", " × ", effect), ": "), second[effect, ]))
    }
  }
  error <- sum(univariate[!duplicated(strata), "error_ss"])
  if (length(within) && !between) {  # the participants are an error term, too
    error <- error + ncol(wide) * sum((rowMeans(wide) - mean(wide))^2)
  }
  levels <- lapply(cells[within], function(f) length(unique(f)))
  for (effect in rownames(univariate)) {
    row <- univariate[effect, ]
    label <- paste0(gsub(":", " × ", effect), ": ")
    values <- c(
      row,
      partial_eta_squared = unname(row["ss"] / (row["ss"] + row["error_ss"])),
      prefixed("partial_eta_squared_", eta_interval(row[["f"]], row[["df"]], row[["df_error"]])),
      generalised_eta_squared = unname(row["ss"] / (row["ss"] + error))
    )
    add("anova", name, prefixed(label, values))
    corrections <- out$pval.adjustments
    used <- setdiff(strsplit(effect, ":")[[1]], "group")
    contrasted <- wide %*% contrasts_of(levels, used)
    if (length(used) && ncol(contrasted) > 1) {
      values <- setNames(corrections[effect, ], CORRECTIONS)
      # car's table is not to be used where the error matrix is singular.
      if (all(is.finite(values))) add("anova", name, prefixed(label, values))
      add("anova", name, prefixed(label, base_table(contrasted, group, effect)))
      if (model$df.residual >= ncol(contrasted)) {
        test <- mauchly.test(if (between) lm(contrasted ~ group) else lm(contrasted ~ 1))
        values <- c(mauchly_w = unname(test$statistic), mauchly_p = test$p.value)
        add("anova", name, prefixed(label, values))
      }
    }
  }
  long <- data.frame(
    y = c(wide), who = rep(rownames(wide), ncol(wide)),
    cell = rep(cells$cell, each = nrow(wide)), group = rep(group, ncol(wide))
  )
  formula <- if (!between) y ~ who + cell else if (!length(within)) y ~ group else
    y ~ who + cell * group
  left <- residuals(lm(formula, long))
  add("anova", name, c(residual_squares = sum(left^2), residual_largest = max(abs(left))))
}

# --- Two groupings, of unequal sizes: types II and III ------------------------------------------
for (set in by_dataset("two_groupings.csv")) {
  wide <- tapply(set$score, list(set$participant, set$condition), identity)
  first <- match(rownames(wide), set$participant)
  people <- data.frame(view = factor(set$view[first]), skill = factor(set$skill[first]))
  contrasts(people$view) <- contrasts(people$skill) <- contr.sum(2)
  model <- lm(wide ~ view * skill, people)
  idata <- data.frame(condition = factor(colnames(wide)))
  for (type in c("II", "III")) {
    table <- summary(Anova(model, idata = idata, idesign = ~condition, type = type),
      multivariate = FALSE
    )
    table <- unclass(table$univariate.tests)[-1, ]
    colnames(table) <- c("ss", "df", "error_ss", "df_error", "f", "p")
    for (effect in rownames(table)) {
      label <- sprintf("%s %s: ", type, gsub(":", " × ", effect))
      add("two_groupings", set$dataset[1], prefixed(label, table[effect, ]))
    }
  }
}

# --- Friedman ---------------------------------------------------------------------------------
for (set in by_dataset("blocks.csv")) {
  name <- set$dataset[1]
  wide <- tapply(as.numeric(set$score), list(set$participant, set$condition), identity)
  wide <- wide[complete.cases(wide), ]
  test <- friedman.test(wide)
  add("friedman", name, c(
    n = nrow(wide), chi_square = unname(test$statistic), df = unname(test$parameter),
    p = test$p.value
  ))
  if (is.finite(test$statistic)) {
    add("friedman", name, c(kendall_w = kendalls_w(wide, ci = NULL, verbose = FALSE)$Kendalls_W))
  }
}

# --- Mixed model ------------------------------------------------------------------------------
for (set in by_dataset("exposures.csv")) {
  name <- set$dataset[1]
  set$score <- as.numeric(set$score)
  set$condition <- factor(set$condition)
  set$period <- factor(set$period)
  formulas <- list(score ~ condition, score ~ condition + period)
  for (formula in formulas[c(TRUE, nlevels(set$period) > 1)]) {
    factors <- attr(terms(formula), "term.labels")
    prefix <- paste0(paste(factors, collapse = " + "), "; ")
    model <- lmer(update(formula, . ~ . + (1 | participant)), set, control = PRECISE)
    sds <- as.data.frame(VarCorr(model))$sdcor
    add("mixed_model", name, prefixed(prefix, c(
      n_participants = length(unique(set$participant)), n_values = nrow(set),
      participant_sd = sds[1], residual_sd = sds[2]
    )))
    table <- coef(summary(model))
    for (term in setdiff(rownames(table), "(Intercept)")) {
      factor <- factors[startsWith(term, factors)]
      level <- sub(factor, "", term)
      label <- sprintf("%s%s: %s − %s ", prefix, factor, level, levels(set[[factor]])[1])
      values <- t_row(table[term, "Estimate"], table[term, "Std. Error"], table[term, "df"])
      add("mixed_model", name, prefixed(label, values))
    }
    table <- anova(model)
    for (factor in factors) {
      test <- unlist(table[factor, c("F value", "NumDF", "DenDF", "Pr(>F)")])
      names(test) <- c("f", "df_effect", "df_error", "p")
      add("mixed_model", name, prefixed(sprintf("%s%s: ", prefix, factor), test))
    }
  }
}

# --- Families of tests, tables of counts ------------------------------------------------------
families <- read.csv("p_values.csv")
for (set in split(families, factor(families$dataset, unique(families$dataset)))) {
  adjusted <- p.adjust(set$p, "holm")
  add("holm", set$dataset[1], setNames(adjusted, set$test))
}
tables <- read.csv("counts.csv")
for (i in seq_len(nrow(tables))) {
  test <- fisher.test(matrix(as.numeric(tables[i, -1]), 2, byrow = TRUE))
  add("fisher_exact", tables$dataset[i], c(p = test$p.value))
}

write.csv(do.call(rbind, found), "r_output.csv", row.names = FALSE, quote = FALSE, na = "")
packages <- c("car", "coin", "effectsize", "exactRankTests", "lme4", "lmerTest")
data <- setdiff(sort(list.files(pattern = "csv$")), "r_output.csv")
writeLines(
  c(
    R.version.string, paste(packages, sapply(packages, function(p) format(packageVersion(p)))),
    "", "MD5 sums of the data:", paste(tools::md5sum(data), data)
  ),
  "r_session.txt"
)
